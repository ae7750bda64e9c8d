// A display transform as a table of bytes, where it treats each channel by itself.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "io/display/display.h"

namespace emberline {

// byte(c, x) is what to_byte() makes of the transform's channel c for the linear value x. A byte is
// how many thresholds x has reached; a table by the float's upper 16 bits says how many of them its
// cell begins with, and the few in the cell are compared with.
//
// The curve must rise, but for differences of rounding: at a threshold the table may then be a few
// units in the last place of x away from where the transform changes.
class DisplayTable {
 public:
  // Null for a transform that mixes channels, as film looks do, or whose curve does not rise.
  static std::unique_ptr<const DisplayTable> make(const DisplayTransform& transform);

  uint8_t byte(size_t channel, float x) const {
    const Curve& curve = curves_[channel];
    if (!(x > 0.0f)) return curve.cells[0];  // NaN counts as 0
    if (x > kLargest) x = kLargest;
    uint32_t reached = curve.cells[std::bit_cast<uint32_t>(x) >> 16];
    while (x >= curve.thresholds[reached]) ++reached;
    return uint8_t(reached);
  }

 private:
  static constexpr float kLargest = 65504.0f;  // as DisplayTransform::apply
  static constexpr size_t kCells = (std::bit_cast<uint32_t>(kLargest) >> 16) + 1;

  struct Curve {
    // thresholds[k]: the least x whose byte is k + 1 or more; infinity if there is none.
    std::array<float, 256> thresholds;
    std::vector<uint8_t> cells;  // of the least value with these upper bits
  };

  DisplayTable() = default;

  std::array<Curve, 3> curves_;
};

}  // namespace emberline
