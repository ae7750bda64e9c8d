#include "renderer/drivers/adaptive/error_metric.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "renderer/core/names.h"

namespace emberline {
namespace {

constexpr ErrorMetricEntry kMetrics[] = {
    {"display", "squared error of the picture as it is looked at (sRGB)", ErrorMetric::kDisplay},
    {"mse", "squared error of linear radiance", ErrorMetric::kMse},
    {"relmse", "squared error over squared radiance", ErrorMetric::kRelMse},
};

float srgb(double x) {
  return float(x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

// The curve at floats whose mantissas are multiples of 2^-6, from 2^-9, where it is still straight,
// to 1: finer where it bends more.
constexpr uint32_t kStepBits = 23 - 6;
constexpr uint32_t kFirstBits = std::bit_cast<uint32_t>(0x1p-9f);
constexpr uint32_t kSteps = (std::bit_cast<uint32_t>(1.0f) - kFirstBits) >> kStepBits;

struct Curve {
  std::array<float, kSteps + 2> values;
  Curve() {
    for (uint32_t i = 0; i < values.size(); ++i) {
      values[i] = std::min(1.0f, srgb(double(std::bit_cast<float>(kFirstBits + (i << kStepBits)))));
    }
  }
};
const Curve kCurve;

}  // namespace

std::span<const ErrorMetricEntry> error_metric_table() { return kMetrics; }

ErrorMetric parse_error_metric(std::string_view name) {
  return find_named(kMetrics, "--allocation", "metric", name).metric;
}

float display_value(float linear) {
  const float x = linear > 0.0f ? std::min(linear, 1.0f) : 0.0f;  // NaN too becomes 0
  if (x < 0x1p-9f) return 12.92f * x;
  const uint32_t offset = std::bit_cast<uint32_t>(x) - kFirstBits;
  const uint32_t step = offset >> kStepBits;
  const float part = float(offset & ((1u << kStepBits) - 1)) * (1.0f / float(1u << kStepBits));
  const float low = kCurve.values[step], high = kCurve.values[step + 1];
  return low + part * (high - low);
}

float error_weight(ErrorMetric metric, float epsilon, float mean, float deviation) {
  switch (metric) {
    case ErrorMetric::kMse:
      return 1.0f;
    case ErrorMetric::kRelMse:
      return 1.0f / (mean * mean + epsilon);
    case ErrorMetric::kDisplay:
      break;
  }
  // Not less than what the table resolves.
  const float d = std::max(deviation, 1e-3f);
  const float slope = (display_value(mean + d) - display_value(mean - d)) / (2 * d);
  return std::max(slope * slope, kLeastDisplaySlope * kLeastDisplaySlope);
}

}  // namespace emberline
