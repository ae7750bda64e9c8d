// `adaptive`: samples go where the error is, round by round (after Painter & Sloan 1989,
// "Antialiased Ray Tracing by Adaptive Progressive Refinement", with today's estimators beside
// theirs).
//
// A first sample for every pixel, in the order that the refinement tree finds for them; then the
// estimator's pilot; then rounds: at each barrier the planner looks at the film and says how many
// samples every pixel is to have next.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

// The pixels of a window in the order in which a round visits them: tiles of 16 x 16 pixels row by
// row, and within a tile row by row, so that neighbours in the list are neighbours in the frame. By
// index, rows from the window's top.
std::vector<uint32_t> tile_order(const Rect& window);

// Cuts a round's list of pixels into parts of about `samples` samples (at least one pixel each):
// entry p is part p's first place in the list, the last entry the list's length. Pixel order[k] is
// to go from have[order[k]] to targets[order[k]] samples.
std::vector<size_t> cut_into_parts(std::span<const uint32_t> order, std::span<const uint32_t> have,
                                   std::span<const uint32_t> targets, uint64_t samples);

// The parts in the order of what their samples are expected to bring: a picture that is looked at,
// or stopped, amid a round has had its worst places seen to. gain[i] is the squared error that the
// samples of pixel i in this round take away; a part's rank is the sum over its pixels by its
// samples. Equal parts come in van der Corput's order, spread over the frame.
std::vector<uint32_t> parts_by_gain(std::span<const size_t> parts, std::span<const uint32_t> order,
                                    std::span<const uint32_t> have,
                                    std::span<const uint32_t> targets, std::span<const float> gain);

class AdaptiveDriver final : public FrameDriver {
 public:
  // Throws UsageError for settings that make no sense together.
  explicit AdaptiveDriver(const DriverSettings& settings);
  ~AdaptiveDriver() override;
  FrameCounters render(const Frame& frame, FrameObserver& observer, std::stop_token stop) override;
  void deliver(FrameObserver& observer) override;
  std::optional<double> error_estimate() const override;
  std::string explain(int x, int y) const override;
  void follow(int x, int y) override;
  const FramePicture* picture() const override;
  const RefinementTree* tree() const override;
  uint64_t bytes_per_pixel(const AovSet& aovs) const override;
  uint64_t film_bytes() const override;

 private:
  class Progress;  // a render under way, kept for deliver()

  const DriverSettings settings_;
  std::unique_ptr<Progress> progress_;
};

}  // namespace emberline
