// Where a chart's axis begins and ends, and what is written along it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace emberline {

enum class AxisScale : uint8_t { kLinear, kLog };

struct AxisTick {
  double value = 0;
  std::string label;  // empty: a line without a number
};

// Maps values to [0, 1] along an axis.
class AxisRange {
 public:
  // Holds every one of `values` that can be drawn, with a margin; [0, 1] (or [1, 10]) if none can.
  // A linear axis begins and ends at a tick. `from_zero`: a linear axis includes 0.
  AxisRange(AxisScale scale, std::span<const double> values, bool from_zero = false);

  // NaN, infinities and what is beyond 1e100 cannot be drawn, on a logarithmic axis neither what is
  // below 1e-100.
  static bool drawable(AxisScale scale, double value);

  // 0 at the axis' beginning, 1 at its end; outside for what lies outside. `value` is drawable.
  double place(double value) const;
  double min() const { return min_; }
  double max() const { return max_; }
  // Round numbers inside the range, ascending, about `wanted` of them labelled: multiples of 1, 2
  // or 5 times a power of ten (Heckbert 1990, "Nice Numbers for Graph Labels", Graphics Gems), on a
  // logarithmic axis powers of ten and, where they are few, 2 and 5 times those.
  std::vector<AxisTick> ticks(int wanted = 6) const;

 private:
  std::vector<AxisTick> linear_ticks(int wanted) const;
  std::vector<AxisTick> log_ticks(int wanted) const;

  AxisScale scale_;
  double min_ = 0, max_ = 1;
};

// 1, 2 or 5 times a power of ten: the smallest such step that divides `range` (> 0) into at most
// `most` parts.
double nice_step(double range, int most);

// A tick's number: "0.25", "1500", "2×10⁻⁵"; as many decimals as tell multiples of `step` apart.
std::string tick_label(double value, double step);

}  // namespace emberline
