// Compares the row buffers and vector loops of the default estimator with its definition, pixel by
// pixel.
#include "renderer/drivers/adaptive/two_stream_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "renderer/drivers/adaptive/error_estimator.h"
#include "unit/synthetic_pixels.h"

namespace emberline::test {
namespace {

struct ErrorEstimate {
  double error = 0, deviation = 0;
};

// The definition from the header, in double, with sums over the 5 x 5 pixels around (px, py).
ErrorEstimate estimate_error(const PixelStatistics& p, ErrorMetric allocation, int px, int py) {
  constexpr double kSigma = 1.2, kPrior = 0.1;
  double weight = 0, freedom = 0, streams = 0, mean[3] = {}, spread[3] = {}, difference[3] = {},
         seen[3] = {};
  for (int y = std::max(0, py - 2); y <= std::min(p.height - 1, py + 2); ++y) {
    for (int x = std::max(0, px - 2); x <= std::min(p.width - 1, px + 2); ++x) {
      const size_t i = size_t(y) * size_t(p.width) + size_t(x);
      const double k =
          std::exp(-((x - px) * (x - px) + (y - py) * (y - py)) / (2 * kSigma * kSigma));
      const double n = double(p.count[i]), b = double(p.second_count[i]), a = n - b;
      weight += n > 0 ? k : 0;
      freedom += k * std::max(0.0, n - 1);
      streams += b > 0 ? k : 0;
      for (size_t c = 0; c < 3; ++c) {
        mean[c] += k * double(p.mean[c][i]);
        spread[c] += k * std::max(0.0, n - 1) * double(p.variance[c][i]);
        if (b == 0) continue;
        const double squared = std::pow(double(p.stream_difference[c][i]), 2) * a * b / n;
        difference[c] += k * squared;
        seen[c] +=
            k * squared *
            double(display_error_weight(p.mean[c][i], std::sqrt(p.variance[c][i] / float(n))));
      }
    }
  }
  const size_t i = size_t(py) * size_t(p.width) + size_t(px);
  const double n = std::max(1.0, double(p.count[i]));
  ErrorEstimate sum;
  for (size_t c = 0; c < 3; ++c) {
    const double pooled = freedom > 0 ? spread[c] / freedom : 1.0;
    const double honest = streams > 0 ? difference[c] / streams : pooled;
    const double value = mean[c] / std::max(weight, 1e-6);
    const auto in = [&](ErrorMetric metric) {
      if (metric == ErrorMetric::kMse) return 1.0;
      if (metric == ErrorMetric::kRelMse) return 1 / (value * value + double(rel_mse_epsilon(p)));
      return double(display_error_weight(float(value), float(std::sqrt(pooled / n))));
    };
    const double shown = streams > 0 ? seen[c] / streams : in(ErrorMetric::kDisplay)*pooled;
    sum.error += shown / n / 3;
    const double streamed = allocation == ErrorMetric::kDisplay ? shown : in(allocation)*honest;
    // Blends the pooled variance with the pixel's own. The weight of the pooled one is 128, that of
    // the pixel's own is the number of its samples beyond 64.
    const double degrees = std::max(0.0, double(p.count[i]) - 64);
    const double near = (128 * pooled + degrees * double(p.variance[c][i])) / (128 + degrees);
    const double wider = pooled > 0 ? near / pooled : 1.0;
    sum.deviation += wider * (streamed + kPrior * in(allocation)*pooled) / (1 + kPrior) / 3;
  }
  return {std::sqrt(sum.error), std::sqrt(sum.deviation)};
}

// The counts are 0 to 24 and 256 to 280, so that neighbours differ. Some pixels lack one or both
// streams.
PixelStatistics uneven_pixels(int width, int height) {
  PixelStatistics pixels = constant_pixels(width, height, 0.0f, 0.0f);
  for (size_t i = 0; i < pixels.size(); ++i) {
    TestRandom random(11, i);
    const auto n = float(8 * (random.bits() % 4) + (random.bits() % 8 == 0 ? 256 : 0));
    pixels.count[i] = n;
    pixels.second_count[i] = random.bits() % 5 == 0 ? 0.0f : n / 2;
    for (size_t c = 0; c < 3; ++c) {
      if (n == 0.0f) continue;
      pixels.mean[c][i] = float(random.next_double());
      pixels.variance[c][i] = float(0.1 * random.next_double());
      const bool two = pixels.second_count[i] > 0.0f;
      pixels.stream_difference[c][i] = two ? float(0.1 * random.next_double() - 0.05) : 0.0f;
    }
  }
  return pixels;
}

constexpr ErrorMetric kMetrics[] = {ErrorMetric::kDisplay, ErrorMetric::kMse, ErrorMetric::kRelMse};

TEST(TwoStreamEstimator, IsItsDefinition) {
  // The heights are around those of the kernel and of the rows of one thread.
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {9, 1}, {5, 3}, {37, 67}}) {
    const PixelStatistics pixels = uneven_pixels(width, height);
    for (const ErrorMetric metric : kMetrics) {
      ErrorMap map;
      estimate_two_stream(pixels, {.allocation = metric}, &map);
      for (size_t i = 0; i < pixels.size(); ++i) {
        const ErrorEstimate expected =
            estimate_error(pixels, metric, int(i) % width, int(i) / width);
        // The kernel's constants have six digits, and a slope is a difference over at least .002.
        ASSERT_NEAR(double(map.error[i]), expected.error, 3e-4 * expected.error) << i;
        ASSERT_NEAR(double(map.deviation[i]), expected.deviation, 3e-4 * expected.deviation) << i;
      }
    }
  }
}

TEST(TwoStreamEstimator, DeviationsAreFiniteInEveryMetric) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity, 3e38f}) {
    PixelStatistics pixels = uneven_pixels(40, 30);
    pixels.mean[1][333] = pixels.variance[0][600] = pixels.stream_difference[2][900] = bad;
    for (const ErrorMetric metric : kMetrics) {
      ErrorMap map;
      estimate_two_stream(pixels, {.allocation = metric}, &map);
      for (const float deviation : map.deviation) {
        ASSERT_TRUE(std::isfinite(deviation) && deviation >= 0.0f) << deviation << " of " << bad;
      }
    }
  }
}

}  // namespace
}  // namespace emberline::test
