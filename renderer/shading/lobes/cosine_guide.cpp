#include "renderer/shading/lobes/cosine_guide.h"

#include <cassert>
#include <cmath>
#include <numeric>

namespace emberline {
namespace {

// Writes the running sums of the weights, divided by their total.
void set_sums(std::span<const double> weights, std::span<float> sums) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    sums[i] = float(sum / total);
  }
  sums.back() = 1.0f;
}

}  // namespace

CosineGuide::CosineGuide(std::span<const float, kBins> weights) {
  std::array<double, kSize> rows{};
  for (size_t row = 0; row < kSize; ++row) {
    std::array<double, kSize> columns;
    for (size_t column = 0; column < kSize; ++column) {
      columns[column] = double(weights[row * kSize + column]);
      assert(columns[column] > 0);
      rows[row] += columns[column];
    }
    set_sums(columns, columns_[row]);
  }
  set_sums(rows, rows_);
}

Vec3f CosineGuide::main_direction() const {
  int best = 0;
  for (int bin = 1; bin < kBins; ++bin) {
    if (density(bin) > density(best)) best = bin;
  }
  return direction_of((Vec2f(float(best % kSize), float(best / kSize)) + Vec2f(0.5f)) /
                      float(kSize));
}

Vec3f CosineGuide::direction_of(const Vec2f& u) {
  const float sine = std::sqrt(u.y), azimuth = 2 * kPi * u.x;
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), std::sqrt(1.0f - u.y)};
}

}  // namespace emberline
