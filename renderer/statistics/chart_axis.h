// The range of a chart's axis, and its ticks and labels.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace emberline {

enum class AxisScale : uint8_t { kLinear, kLog };

struct AxisTick {
  double value = 0;
  std::string label;  // empty: the tick has no label
};

// Maps values to [0, 1] along an axis.
class AxisRange {
 public:
  // Covers all drawable values. If there are none, the axis covers [0, 1], or [1, 10] if it is
  // logarithmic. A logarithmic axis has a margin at both ends; a linear axis begins and ends at a
  // tick, and includes 0 if `from_zero`.
  AxisRange(AxisScale scale, std::span<const double> values, bool from_zero = false);

  // NaN, infinity and magnitudes above 1e100 are not drawable; on a logarithmic axis, values below
  // 1e-100 are not drawable either.
  static bool drawable(AxisScale scale, double value);

  // Returns 0 at the start of the axis, 1 at its end, and a number outside [0, 1] for a value
  // beyond the ends. `value` must be drawable.
  double position(double value) const;
  double min() const { return min_; }
  double max() const { return max_; }
  // Returns ticks inside the range, ascending; about `target_count` of them have a label. On a
  // linear axis, ticks are at the multiples of 1, 2 or 5 times a power of ten (Heckbert 1990, "Nice
  // Numbers for Graph Labels", Graphics Gems). On a logarithmic axis, they are at powers of ten. If
  // the range has few powers of ten, ticks are also at 2 and 5 times each power.
  std::vector<AxisTick> ticks(int target_count = 6) const;

 private:
  std::vector<AxisTick> linear_ticks(int target_count) const;
  std::vector<AxisTick> log_ticks(int target_count) const;

  AxisScale scale_;
  double min_ = 0, max_ = 1;
};

// Returns the smallest step of 1, 2 or 5 times a power of ten that divides `range` (> 0) into at
// most `max_parts` parts.
double nice_step(double range, int max_parts);

// Returns a text such as "2×10⁻⁵", or "10⁻⁵" if the mantissa is "1".
std::string power_of_ten_text(const std::string& mantissa, int exponent);

// Formats the number of a tick, such as "0.25", "1,500" or "2×10⁻⁵", with enough decimals to
// distinguish multiples of `step`.
std::string tick_label(double value, double step);

}  // namespace emberline
