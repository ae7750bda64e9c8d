#include "renderer/statistics/neyman_limit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace emberline {
namespace {

// Half the width of the interval over which the slope of the display curve is measured, and the
// minimum of the slope. The adaptive driver's display metric uses the same two values.
constexpr float kSlopeHalfWidth = 1e-3f;
constexpr double kMinSlope = 0.02;

std::vector<double> display_weights(const RgbImage& mean) {
  RgbImage low = mean, high = mean;
  for (float& v : low.rgb) v -= kSlopeHalfWidth;
  for (float& v : high.rgb) v += kSlopeHalfWidth;
  const std::vector<uint8_t> all(mean.rgb.size() / 3, 0);
  low = to_display(low, 0, all);
  high = to_display(high, 0, all);
  std::vector<double> weights(mean.rgb.size());
  for (size_t i = 0; i < weights.size(); ++i) {
    const double slope = (double(high.rgb[i]) - double(low.rgb[i])) / (2 * double(kSlopeHalfWidth));
    weights[i] = std::max(slope * slope, kMinSlope * kMinSlope);
  }
  return weights;
}

}  // namespace

double neyman_limit(std::span<const double> variance, std::span<const double> cost, double slope) {
  assert(variance.size() == cost.size() && slope > 0);
  const double root = 1 / (1 + slope), n = double(variance.size());
  double v_sum = 0, c_sum = 0, root_sum = 0;
  for (size_t i = 0; i < variance.size(); ++i) {
    v_sum += variance[i];
    c_sum += cost[i];
    root_sum += std::pow(variance[i], root) * std::pow(cost[i], slope * root);
  }
  if (!(root_sum > 0)) return 1.0;
  // Use means instead of sums, so that powers do not overflow.
  const double uniform = v_sum / n * std::pow(c_sum / n, slope);
  return std::pow(uniform / std::pow(root_sum / n, 1 + slope), 1 / slope);
}

NeymanLimits neyman_limits(std::span<const float> variance, std::span<const float> seconds,
                           const RgbImage& mean, double epsilon) {
  const size_t pixels = seconds.size();
  assert(variance.size() == 3 * pixels && mean.rgb.size() == 3 * pixels);
  const std::vector<double> display = display_weights(mean);
  const std::vector<double> cost(seconds.begin(), seconds.end());
  std::vector<double> mse(pixels), rel_mse(pixels), shown(pixels);
  for (size_t k = 0; k < 3 * pixels; ++k) {
    const double v = std::max(0.0, double(variance[k])) / 3, m = double(mean.rgb[k]);
    if (!std::isfinite(v) || !std::isfinite(m)) continue;
    mse[k / 3] += v;
    rel_mse[k / 3] += v / (m * m + epsilon);
    shown[k / 3] += v * display[k];
  }
  return {neyman_limit(mse, cost), neyman_limit(rel_mse, cost), neyman_limit(shown, cost)};
}

}  // namespace emberline
