// The one place where sampler, camera, filter, integrator and film meet; every driver calls it.
#pragma once

#include <stop_token>

#include "renderer/drivers/frame_driver.h"

namespace emberline {

// A worker thread's own state, reused from item to item so that rendering allocates nothing.
class RenderWorker {
 public:
  // Also sets the thread's floating-point mode as Embree asks (denormals to zero); undone by the
  // destructor.
  explicit RenderWorker(const Frame& frame);
  ~RenderWorker();
  RenderWorker(const RenderWorker&) = delete;
  RenderWorker& operator=(const RenderWorker&) = delete;

  // Adds the item's samples to `tile`, which covers item.pixels. Pixels are visited row by row,
  // each with all its samples in index order. Stops between batches of 16 samples when asked to;
  // returns false then.
  bool render(const WorkItem& item, FilmTile& tile, FrameObserver& observer,
              const std::stop_token& stop);

  // One sample alone, as render() would compute it.
  SampleValue replay(int x, int y, uint32_t sample, Ray* camera_ray);

  const FrameCounters& counters() const { return counters_; }

 private:
  void trace_batch(int x, int y, uint32_t first_sample, int count);

  const Frame& frame_;
  PixelSamples samples_;
  FrameCounters counters_;
  Ray rays_[kSampleLanes];
  float weights_[kSampleLanes];
  SampleValue values_[kSampleLanes];
  unsigned saved_mode_;
};

}  // namespace emberline
