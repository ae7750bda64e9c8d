// Statistics of lists of values: quantiles, and the slope of a line through points.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
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
