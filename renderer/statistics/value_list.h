// Statistics of lists of values: quantiles, summaries, and the slope of a line through points.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

namespace emberline {

// Returns the smallest value v in the list such that at least this fraction of the values are <= v.
// For 1000 values and a fraction of 0.995, this is the 995th in ascending order. The list must not
// be empty.
template <typename T>
double nearest_rank_quantile(std::vector<T> values, double fraction) {
  assert(!values.empty());
  const auto rank =
      std::max<ptrdiff_t>(0, ptrdiff_t(std::ceil(fraction * double(values.size()))) - 1);
  std::ranges::nth_element(values, values.begin() + rank);
  return double(values[size_t(rank)]);
}

struct ValueSummary {
  double median, mean, least, largest;
};

// Ignores NaN and infinities. Returns nothing if no value is left.
inline std::optional<ValueSummary> summary_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nullopt;
  std::ranges::sort(values);
  const size_t n = values.size();
  return ValueSummary{(values[(n - 1) / 2] + values[n / 2]) / 2,
                      std::accumulate(values.begin(), values.end(), 0.0) / double(n),
                      values.front(), values.back()};
}

// Returns the slope of the least-squares line through the points (x, y). There must be at least two
// points.
inline double least_squares_slope(std::span<const double> x, std::span<const double> y) {
  assert(x.size() == y.size() && x.size() >= 2);
  const auto n = double(x.size());
  double mean_x = 0, mean_y = 0, xy = 0, xx = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / n;
    mean_y += y[i] / n;
  }
  for (size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    xx += (x[i] - mean_x) * (x[i] - mean_x);
  }
  return xy / xx;
}

}  // namespace emberline
