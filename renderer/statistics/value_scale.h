// From values to places along a colour bar, and the numbers that are written beside it.
#pragma once

#include <string>
#include <vector>

#include "renderer/statistics/chart_axis.h"
#include "renderer/statistics/plane.h"

namespace emberline {

struct ValueRange {
  double least = 0, most = 1;
};

// The quantile of the values, 0 left out, at the bright end of an automatic range, so that outliers
// do not leave all else dark. Chosen by looking at densities of thresholds: at .995 they are black.
inline constexpr double kBrightQuantile = 0.98;

// The range for a plane's values if none is asked for. Linear: from 0 (or the least value, if that
// is negative) to the `bright` quantile of the values that are not 0. Logarithmic: from the 0.5 %
// quantile of the values above 0 to the greatest. A constant plane is in the middle. Never empty;
// with `logarithmic` above 0.
ValueRange automatic_range(const Plane& plane, bool logarithmic, double bright = kBrightQuantile);

class ValueScale {
 public:
  // range.least < range.most, with `logarithmic` 0 < range.least (asserted).
  ValueScale(const ValueRange& range, bool logarithmic);

  const ValueRange& range() const { return range_; }
  bool logarithmic() const { return logarithmic_; }
  // 0 at the least value, 1 at the most, beyond them outside; NaN for what is not finite. On a
  // logarithmic scale values up to 0 are below everything: minus infinity.
  double position(double value) const;

  // Inside the range, ascending, at most `most` (>= 2): multiples of 1, 2 or 5 times a power of
  // ten; on a logarithmic scale powers of ten, and where they are few 2 and 5 times those. Labels
  // show value x `factor`, in printable ASCII.
  std::vector<AxisTick> ticks(int most, double factor = 1.0) const;

 private:
  std::vector<AxisTick> linear_ticks(int most, double factor) const;
  // Empty where there are not two such numbers.
  std::vector<double> decade_ticks(int most, double factor) const;

  ValueRange range_;
  bool logarithmic_;
};

// To four significant digits without trailing zeros: "64", "0.0312", "1.5e-07"; from a thousand to
// a million to the nearest whole number.
std::string number_text(double value);

// The unit in which a value of this size is told and the factor to it: seconds as "ms" or "us",
// anything else as it is.
struct ToldUnit {
  double factor = 1;
  std::string name;
};
ToldUnit told_unit(const std::string& unit, double size);

}  // namespace emberline
