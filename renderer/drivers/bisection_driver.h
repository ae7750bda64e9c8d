// `bisection`: progressive refinement after Arikan & Gudukbay (2000). The whole frame can be judged
// from the first milliseconds on; then it goes over the frame again and again, each time for as
// many samples as there are.
#pragma once

#include <optional>
#include <vector>

#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

class BisectionDriver final : public FrameDriver {
 public:
  // Throws UsageError for a bucket size outside [1, 4096], an unknown axis or reconstruction.
  explicit BisectionDriver(const DriverSettings& settings);
  // Throws RenderError where the film does not fit into memory.
  FrameCounters render(const Frame& frame, FrameObserver& observer, std::stop_token stop) override;
  void deliver(FrameObserver& observer) override;
  const FramePicture* picture() const override { return picture_ ? &*picture_ : nullptr; }
  uint64_t bytes_per_pixel(const AovSet& aovs) const override;
  uint64_t film_bytes() const override { return film_ ? film_->bytes() : 0; }

 private:
  void prepare(const Frame& frame, const SampleRange& first_samples);
  void mark_stops(PixelStop cut_short);

  int tile_size_;
  BisectionAxis axis_;
  Reconstruction reconstruction_;
  // Kept from render() for deliver().
  std::vector<BisectionStep> steps_;
  std::optional<BisectionPass> first_pass_;
  std::optional<FilmTile> film_;
  std::optional<BisectionPicture> picture_;
  uint32_t samples_per_pixel_ = 0;
};

// Where the slice that begins with part `first` ends; between slices the frame can be looked at.
// It ends with the part that brings `samples_wanted` samples, if any, or before. In the first pass
// it lies within a step and has at most a hundredth of the frame's pixels (or one part); later
// passes are a slice each, because every pause costs half a part for the threads that wait.
size_t bisection_slice_end(const BisectionPass& pass, size_t first, uint64_t frame_pixels,
                           std::optional<uint64_t> samples_wanted);

// How many pixels of a pass make a part: a power of two.
uint64_t bisection_part_pixels(const SampleRange& samples, uint64_t frame_pixels);

}  // namespace emberline
