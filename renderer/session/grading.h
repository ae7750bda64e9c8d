// Converts linear pictures to display values, fast enough for a window.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "io/display/display.h"

namespace emberline {

class DisplayTable;

// Immutable and thread-safe. Computes the same bytes as DisplayTransform and to_byte(), except
// perhaps for values within a few units in the last place of the threshold between two bytes.
class Grading {
 public:
  // Throws the same errors as DisplayTransform.
  explicit Grading(const DisplaySettings& settings);
  // Reuses the transform of `other`, with a different exposure.
  Grading(const Grading& other, float exposure);

  const DisplaySettings& settings() const { return settings_; }

  // Converts linear, premultiplied RGBA to opaque 8-bit RGBA, composited over black. Both spans are
  // interleaved, have `width` pixels per row, and must be equally long. Identical neighbouring
  // pixels and rows are converted only once, so that the large uniform areas of a frame's first
  // pictures cost almost nothing. Uses the calling thread's TBB arena.
  void grade(std::span<const float> rgba, int width, std::span<uint8_t> rgba8) const;
  // Like grade(), but converts a row or any other run of pixels, on the calling thread alone.
  void grade_run(std::span<const float> rgba, std::span<uint8_t> rgba8) const;

  // Converts to display values in [0, 1] in place, so that the caller can draw over the picture
  // before converting it to bytes. Does not change alpha. Uses the calling thread's TBB arena.
  void to_display(std::span<float> rgba) const;

 private:
  DisplaySettings settings_;
  std::shared_ptr<const DisplayTransform> transform_;  // at exposure 0
  std::shared_ptr<const DisplayTable> table_;          // null if the transform cannot be tabulated
  float scale_;
};

}  // namespace emberline
