// Maps values to positions along a colour bar, and formats the numbers next to it.
#pragma once

#include <string>
#include <vector>

#include "renderer/statistics/chart_axis.h"
#include "renderer/statistics/plane.h"

namespace emberline {

struct ValueRange {
  double min = 0, max = 1;
};

// The bright end of an automatic range is this quantile of the nonzero values, so that outliers do
// not darken everything else. We chose it for density maps of frames with a noise threshold;
// with 0.995, they are black.
inline constexpr double kBrightQuantile = 0.98;

// The default range of a plane. Linear: from 0 (or the minimum, if negative) to the `bright`
// quantile of the nonzero values. Logarithmic: from the 0.5 % quantile of the positive values to
// the maximum. If the plane is constant, its value is in the middle of the range. The range is
// never empty, and is positive if `logarithmic`.
ValueRange automatic_range(const Plane& plane, bool logarithmic, double bright = kBrightQuantile);

class ValueScale {
 public:
  // Requires range.min < range.max and, if `logarithmic`, 0 < range.min (asserted).
  ValueScale(const ValueRange& range, bool logarithmic);

  const ValueRange& range() const { return range_; }
  bool logarithmic() const { return logarithmic_; }
  // 0 at the smallest value of the range, 1 at the largest, and outside [0, 1] for values beyond
  // the range; NaN for non-finite values. On a logarithmic scale, the position of 0 and of negative
  // values is minus infinity.
  double position(double value) const;

  // Returns at most `max` (>= 2) ticks inside the range, ascending. Labels show value x `factor`,
  // which is a multiple of 1, 2 or 5 times a power of ten. On a logarithmic scale, it is a power of
  // ten or, if there are few of these, also 2 or 5 times one.
  std::vector<AxisTick> ticks(int max, double factor = 1.0) const;

 private:
  std::vector<AxisTick> linear_ticks(int max, double factor) const;
  // Returns the labels' numbers on a logarithmic scale; empty if fewer than two of them are in the
  // range.
  std::vector<double> decade_ticks(int max, double factor) const;

  ValueRange range_;
  bool logarithmic_;
};

// Formats a number with four significant digits, without trailing zeros: "64", "0.0312",
// "1.5×10⁻⁷". Numbers from a thousand to a million are rounded to whole numbers: "123,456".
std::string number_text(double value);

// The unit in which values of a certain size are displayed, and the factor that converts them to
// it: "s" may become "ms", "µs" or "ns"; other units do not change.
struct DisplayUnit {
  double factor = 1;
  std::string name;
};
DisplayUnit display_unit(const std::string& unit, double size);

}  // namespace emberline
