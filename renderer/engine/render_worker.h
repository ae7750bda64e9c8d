// Combines sampler, camera, filter, integrator and film. All drivers render with it.
#pragma once

#include <span>
#include <stop_token>
#include <utility>

#include "renderer/core/flush_denormals.h"
#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"
#include "renderer/engine/render_sink.h"
#include "renderer/film/light_group_values.h"
#include "renderer/film/path_layers.h"
#include "renderer/film/sample_shares.h"
#include "renderer/scene/interior.h"
#include "samplers/pixel_samples.h"

namespace emberline {

// The state of a worker thread, reused between parts so that rendering allocates nothing.
class RenderWorker {
 public:
  // From construction to destruction, denormals are flushed to zero on this thread, as Embree
  // recommends.
  explicit RenderWorker(const Frame& frame);
  RenderWorker(const RenderWorker&) = delete;
  RenderWorker& operator=(const RenderWorker&) = delete;

  // Sets the seed of the following samples, which replaces the frame's seed.
  void set_seed(uint32_t seed) { seed_ = seed; }

  // Renders the samples of a list of distinct pixels and adds them to `tile`, which must contain
  // these pixels. Each pixel's samples are added in index order; pixels with few samples share a
  // batch of 16 samples. After a stop request, returns false once the current batch is done.
  bool render(std::span<const PixelWork> list, FilmTile& tile, RenderSink& sink,
              const std::stop_token& stop);

  // Computes a single sample exactly as render() does.
  SampleValue replay(int x, int y, uint32_t sample, Ray* camera_ray);

  // Returns the counts since the last call.
  RenderCounters take_counters() { return std::exchange(counters_, frame_.empty_counters()); }

 private:
  void begin_batch(int x, int y, uint32_t first_sample, int count);
  bool all_empty() const;
  void sample_film_positions(Vec2f* film);
  void trace_batch();
  void add_background_velocity();
  void generate_rays(std::span<const Vec2f> film);
  void generate_lens_rays(std::span<const Vec2f> film);
  void generate_timed_rays(std::span<const Vec2f> film);
  void add(int lane, FilmTile& tile);
  void add_batch(FilmTile& tile);
  void flush_partial_batch(FilmTile& tile);

  const Frame& frame_;
  uint32_t seed_;
  const bool has_sample_weights_;  // the sampler's points have unequal weights
  PixelSamples samples_;
  const bool needs_first_hits_, needs_hit_ids_, needs_features_, needs_catchers_;
  RenderCounters counters_;
  SampleAddress addresses_[kSampleLanes];  // of the current batch
  int count_ = 0;
  Ray rays_[kSampleLanes];
  float weights_[kSampleLanes];
  SampleValue values_[kSampleLanes];
  DenoiserFeatures features_[kSampleLanes];
  SampleShares shares_[kSampleLanes];
  CatcherSample catcher_samples_[kSampleLanes];
  Interior interiors_[kSampleLanes];
  LightGroupValues light_values_;
  const PathLayers path_layers_;
  LightGroupValues layer_values_;
  const FlushDenormals flush_;
};

}  // namespace emberline
