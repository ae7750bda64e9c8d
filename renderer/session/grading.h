// From a linear picture to what the screen shows, as fast as a window needs it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "io/display/display.h"

namespace emberline {

class DisplayTable;

// Immutable; thread-safe. Gives the bytes that DisplayTransform and to_byte() give.
class Grading {
 public:
  // Throws as DisplayTransform does.
  explicit Grading(const DisplaySettings& settings);
  // Reuses the transform of `other` at another exposure, without reading or compiling it again.
  Grading(const Grading& other, float exposure);

  const DisplaySettings& settings() const { return settings_; }

  // Interleaved RGBA, linear and premultiplied, to interleaved 8-bit RGBA: as seen over black,
  // opaque. `width` pixels a row; the spans hold equally many values. A picture of large areas of
  // one colour, as the first ones of a frame are, costs next to nothing: neighbours and rows that
  // repeat are graded once. Works on the calling thread's TBB arena.
  void grade(std::span<const float> rgba, int width, std::span<uint8_t> rgba8) const;
  // One row, or any run of pixels, on the calling thread alone.
  void grade_run(std::span<const float> rgba, std::span<uint8_t> rgba8) const;

  // To display values in [0, 1], in place, for what is drawn over the picture before it becomes
  // bytes; alpha stays. As grade().
  void to_display(std::span<float> rgba) const;

 private:
  DisplaySettings settings_;
  std::shared_ptr<const DisplayTransform> transform_;  // at exposure 0
  std::shared_ptr<const DisplayTable> table_;          // null where it cannot be one
  float scale_;
};

}  // namespace emberline
