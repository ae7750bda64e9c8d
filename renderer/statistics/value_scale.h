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
// not darken everything else. We chose 0.98 for density maps of frames with a noise threshold; with
// 0.995, these maps are black.
inline constexpr double kBrightQuantile = 0.98;

// Returns the default range of a plane. A linear range extends from 0 (or the minimum, if negative)
// to the `bright` quantile of the nonzero values. A logarithmic range extends from the 0.5 %
// quantile of the positive values to the maximum. If the plane is constant, its value is in the
// middle of the range. The range is never empty; if `logarithmic`, it is positive.
ValueRange automatic_range(const Plane& plane, bool logarithmic, double bright = kBrightQuantile);

class ValueScale {
 public:
  // Requires range.min < range.max and, if `logarithmic`, 0 < range.min (asserted).
  ValueScale(const ValueRange& range, bool logarithmic);

  const ValueRange& range() const { return range_; }
  bool logarithmic() const { return logarithmic_; }
  // Returns 0 at the smallest value of the range, 1 at the largest, a number outside [0, 1] for
  // values beyond the range, and NaN for non-finite values. On a logarithmic scale, returns minus
  // infinity for 0 and negative values.
  double position(double value) const;

  // Returns at most `max` (>= 2) ticks inside the range, ascending. The label of a tick is its
  // value times `factor`. On a linear scale, the labels are multiples of 1, 2 or 5 times a power of
  // ten. On a logarithmic scale, they are powers of ten. If the range has few powers of ten, they
  // are also 2 and 5 times each power.
  std::vector<AxisTick> ticks(int max, double factor = 1.0) const;

 private:
  std::vector<AxisTick> linear_ticks(int max, double factor) const;
  // Returns the numbers of the labels on a logarithmic scale; nothing if fewer than two of them are
  // in the range.
  std::vector<double> decade_ticks(int max, double factor) const;

  ValueRange range_;
  bool logarithmic_;
};

// Formats a number with four significant digits, without trailing zeros: "64", "0.0312",
// "1.5×10⁻⁷". Numbers from a thousand to a million are rounded to whole numbers: "123,456".
std::string number_text(double value);

// The unit in which values of a certain size are displayed, and the factor that converts values to
// this unit: "s" may become "ms", "µs" or "ns"; other units do not change.
struct DisplayUnit {
  double factor = 1;
  std::string name;
};
DisplayUnit display_unit(const std::string& unit, double size);

}  // namespace emberline
