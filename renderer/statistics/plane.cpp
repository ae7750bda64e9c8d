#include "renderer/statistics/plane.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/vector.h"
#include "renderer/statistics/row_sums.h"

namespace emberline {
namespace {

struct RowStatistics {
  uint64_t values = 0, nonzero = 0;
  double sum = 0, squares = 0;
  float minimum = INFINITY, maximum = -INFINITY;

  RowStatistics& operator+=(const RowStatistics& row) {
    values += row.values;
    nonzero += row.nonzero;
    sum += row.sum;
    squares += row.squares;
    minimum = std::min(minimum, row.minimum);
    maximum = std::max(maximum, row.maximum);
    return *this;
  }
};

}  // namespace

PlaneStatistics plane_statistics(const Plane& plane) {
  const auto sums = sum_rows<RowStatistics>(plane.height, [&](int y) {
    RowStatistics row;
    for (int x = 0; x < plane.width; ++x) {
      const float value = plane.at(x, y);
      if (!std::isfinite(value)) continue;
      row.values++;
      row.nonzero += value != 0.0f;
      row.sum += double(value);
      row.squares += double(value) * double(value);
      row.minimum = std::min(row.minimum, value);
      row.maximum = std::max(row.maximum, value);
    }
    return row;
  });
  PlaneStatistics s;
  s.values = sums.values;
  s.no_value = plane.values.size() - sums.values;
  s.nonzero = sums.nonzero;
  if (sums.values == 0) return s;
  const auto n = double(sums.values);
  s.minimum = double(sums.minimum);
  s.maximum = double(sums.maximum);
  s.mean = s.constant() ? s.minimum : sums.sum / n;  // exact if all values are equal
  s.rms = s.constant() ? std::abs(s.minimum) : std::sqrt(sums.squares / n);
  return s;
}

}  // namespace emberline
