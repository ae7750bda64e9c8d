// `bisection`: progressive refinement after Arikan & Gudukbay (2000). The whole frame can be judged
// after the first milliseconds. Each further pass over the frame doubles the number of samples.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

// A round is a hundredth of the first pass at most, or one of the further passes.
class BisectionDriver final : public FrameDriver {
 public:
  BisectionDriver(const Frame& frame, const Rect& crop, const DriverSettings& settings);

  std::optional<Round> next(FilmTile& film, const std::stop_token& stop) override;
  Round round() const override;
  void expand(size_t part, std::vector<PixelWork>& list) const override;
  uint64_t samples(size_t part) const override;
  void rendered(const RenderedParts& parts, const FilmTile& film) override;
  bool finished() const override { return least_samples_ == samples_per_pixel_; }
  uint32_t least_samples(const FilmTile&) const override {
    return std::max(least_samples_, extended_);
  }
  PixelStop stop_so_far(const FilmTile& film, int x, int y) const override;
  void resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const override;
  void end(FilmTile& film, PixelStop cut_short) override;
  DriverFacts facts() const override {
    const size_t steps = coverage_.complete_steps;
    return {.lattice = steps > 0 ? &first_.steps[steps - 1].complete : nullptr};
  }
  void archive(Archive& archive, const FilmTile& film) override;
  void extend(Archive& finished, const FilmTile& film) override;

 private:
  // One pass, and the lines that it goes by.
  struct Pass {
    Pass(const Rect& crop, const SampleRange& samples, BisectionAxis axis);
    std::vector<BisectionStep> steps;
    BisectionPass parts;
  };
  const Pass& pass() const { return later_ ? *later_ : first_; }

  const Rect crop_;
  const uint32_t seed_, samples_per_pixel_;
  const BisectionAxis axis_;
  const Reconstruction reconstruction_;
  const std::vector<SampleRange> passes_;
  const Pass first_;
  std::optional<Pass> later_;
  size_t pass_ = 0;             // which of the passes is under way
  size_t begin_ = 0, end_ = 0;  // of its parts: the round under way
  BisectionCoverage coverage_;  // of the first pass
  uint32_t least_samples_ = 0;  // of the requested ones
  uint32_t extended_ = 0;       // samples of every pixel in the frame that this one extends
};

// The end of the round that begins with part `first`. In the first pass a round stays within a step
// and has at most a hundredth of the frame's pixels (or one part), so that the picture can be shown
// often. Each later pass is one round, because every pause costs waiting threads half a part.
size_t bisection_round_end(const BisectionPass& pass, size_t first, uint64_t frame_pixels);

// How many pixels of a pass make a part: a power of two.
uint64_t bisection_part_pixels(const SampleRange& samples, uint64_t frame_pixels);

}  // namespace emberline
