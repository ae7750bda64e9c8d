// Converts linear pictures to display values, fast enough for a window.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "io/display/display.h"

namespace emberline {

class DisplayTable;

// Immutable and thread-safe. Gives the same bytes as DisplayTransform and to_byte().
class Grading {
 public:
  // Throws as DisplayTransform does.
  explicit Grading(const DisplaySettings& settings);
  // Reuses the transform of `other` at another exposure.
  Grading(const Grading& other, float exposure);

  const DisplaySettings& settings() const { return settings_; }

  // Converts linear, premultiplied RGBA to opaque 8-bit RGBA, composited over black. Both are
  // interleaved with `width` pixels per row and equally long. Equal neighbours and rows are
  // converted once, which makes large uniform areas, as in a frame's first pictures, almost free.
  // Uses the calling thread's TBB arena.
  void grade(std::span<const float> rgba, int width, std::span<uint8_t> rgba8) const;
  // Grades a row or any run of pixels on the calling thread alone.
  void grade_run(std::span<const float> rgba, std::span<uint8_t> rgba8) const;

  // Converts to display values in [0, 1] in place, for drawing over the picture before it becomes
  // bytes; alpha is unchanged. Uses the calling thread's TBB arena.
  void to_display(std::span<float> rgba) const;

 private:
  DisplaySettings settings_;
  std::shared_ptr<const DisplayTransform> transform_;  // at exposure 0
  std::shared_ptr<const DisplayTable> table_;          // null if the transform cannot be a table
  float scale_;
};

}  // namespace emberline
