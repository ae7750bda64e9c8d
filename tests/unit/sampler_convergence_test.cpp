// How fast the sobol sampler converges, that padding is not a trap, and that two streams tell the
// truth about the error. Every figure is an average over thousands of seeds with exact means.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "renderer/core/vector.h"
#include "samplers/owen_sobol.h"
#include "unit/sample_statistics.h"

namespace emberline {
namespace {

constexpr double kPiDouble = std::numbers::pi;

// Integrands over the numbers of the camera slot, with their exact means.
struct Integrand {
  const char* name;
  double (*value)(const SlotNumbers&);
  double mean;
  double order;  // variance ~ N^-order with the sobol sampler
};

double smooth(const SlotNumbers& n) { return double(n.u[0]) * n.u[0] * std::exp(double(n.u[1])); }
// One third: its distance to the grid of N = 2^m strata is N-independent, so that the error is
// exactly 2/9 / N^2 (one stratum in doubt, inside with probability 1/3 or 2/3).
constexpr float kThird = 1.0f / 3.0f;
double axis_edge(const SlotNumbers& n) { return n.u[0] < kThird ? 1.0 : 0.0; }
double tilted_edge(const SlotNumbers& n) { return n.u[1] < 0.3f + 0.37f * n.u[0] ? 1.0 : 0.0; }
double disc(const SlotNumbers& n) {
  const double x = n.u[0] - 0.5, y = n.u[1] - 0.5;
  return x * x + y * y < 0.16 ? 1.0 : 0.0;
}
// Couples the pixel pair with the lens pair.
double coupled(const SlotNumbers& n) {
  const double x = n.u[0] - n.u[2], y = n.u[1] - n.u[3];
  return std::exp(-4.0 * (x * x + y * y));
}
// Couples two pairs that are both shuffled.
double coupled_shuffled(const SlotNumbers& n) {
  const double x = n.u[4] - n.u[2], y = n.u[5] - n.u[3];
  return std::exp(-4.0 * (x * x + y * y));
}
double signs(const SlotNumbers& n) { return (n.u[0] < 0.5f) == (n.u[2] < 0.5f) ? 1.0 : -1.0; }
// The same at a scale that blocks of 8 do not resolve: parity of the fourth binary digits.
double fine_signs(const SlotNumbers& n) {
  return ((int(n.u[0] * 16.0f) ^ int(n.u[2] * 16.0f)) & 1) == 0 ? 1.0 : -1.0;
}
// An edge seen by the pixel times the soft shadow of a light.
double edge_and_shadow(const SlotNumbers& n) {
  return n.u[1] < 0.3f + 0.37f * n.u[0] && n.u[2] + n.u[3] < 0.8f + 0.4f * n.u[0] ? 1.0 : 0.0;
}

// Integral over the unit square of exp(-c (a - b)^2).
double gauss_pair(double c) {
  return std::sqrt(kPiDouble / c) * std::erf(std::sqrt(c)) - (1.0 - std::exp(-c)) / c;
}
// Integral over x of (0.3 + 0.37 x) * area(a + b < 0.8 + 0.4 x); the area is s^2 / 2 up to s = 1
// (x = 1/2), then 1 - (2 - s)^2 / 2. Simpson's rule is exact for cubics, piece by piece.
double edge_and_shadow_mean() {
  const auto f = [](double x) {
    const double s = 0.8 + 0.4 * x;
    return (0.3 + 0.37 * x) * (s <= 1.0 ? 0.5 * s * s : 1.0 - 0.5 * (2.0 - s) * (2.0 - s));
  };
  return (f(0.0) + 4 * f(0.25) + 2 * f(0.5) + 4 * f(0.75) + f(1.0)) / 12.0;
}

// Mean squared error of the mean after each count, over `seeds` pixels.
std::vector<double> error_curve(const Sampler& sampler, const Integrand& integrand, uint32_t seeds,
                                const std::vector<uint32_t>& counts) {
  std::vector<double> error(counts.size());
  for (uint32_t s = 0; s < seeds; ++s) {
    double sum = 0;
    size_t next = 0;
    for_each_sample(sampler, {s, s / 7, 11}, 0, counts.back(),
                    [&](uint32_t k, const SlotNumbers& n) {
                      sum += integrand.value(n);
                      if (k + 1 == counts[next]) {
                        const double difference = sum / (k + 1) - integrand.mean;
                        error[next++] += difference * difference / seeds;
                      }
                    });
  }
  return error;
}

TEST(SobolConvergence, OrdersAreTheTextbooks) {
  const Integrand integrands[] = {
      {"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 2.9},
      {"axis edge", axis_edge, kThird, 2.0},
      {"tilted edge", tilted_edge, 0.3 + 0.37 / 2, 1.49},
      {"disc", disc, 0.16 * kPiDouble, 1.57},
      {"4D coupled, padded", coupled, square(gauss_pair(4.0)), 1.0},
  };
  const auto sampler = create_sampler("sobol", {StreamCount::kOne});
  const std::vector<uint32_t> counts = {16, 32, 64, 128, 256, 512, 1024, 2048, 4096};
  for (const Integrand& integrand : integrands) {
    const std::vector<double> error = error_curve(*sampler, integrand, 2000, counts);
    std::vector<double> x, y;
    for (size_t i = 0; i < counts.size(); ++i) {
      x.push_back(std::log(counts[i]));
      y.push_back(std::log(error[i]));
    }
    const double order = -slope(x, y);
    std::cout << "[ measured ] variance ~ N^-" << order << " for " << integrand.name << "\n";
    EXPECT_NEAR(order, integrand.order, 0.1) << integrand.name;
  }
}

TEST(IndependentConvergence, VarianceIsOneOverN) {
  const auto sampler = create_sampler("independent", {});
  const std::vector<uint32_t> counts = {16, 64, 256};
  // Variance of an indicator with mean m is m (1 - m); 2000 seeds know it to 3.2 %, the band is 5.5
  // of those.
  const double m = 0.16 * kPiDouble;
  const std::vector<double> error = error_curve(*sampler, {"disc", disc, m, 1.0}, 2000, counts);
  for (size_t i = 0; i < counts.size(); ++i) {
    EXPECT_NEAR(error[i] * counts[i] / (m * (1 - m)), 1.0, 0.175) << counts[i] << " samples";
  }
}

// The sampler that one would write first: every pair shuffled by an Owen shuffle of the whole index
// (Burley 2020). It is here to show that the test below can fail.
class NestedShuffleOnly final : public Sampler {
 public:
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first, int count, SlotBlock& out,
            int /*dimensions*/) const override {
    const uint32_t hash =
        hash_combine(hash_combine(hash_combine(pixel.seed, pixel.x), pixel.y), slot);
    for (uint32_t p = 0; p < kSlotDimensions / 2; ++p) {
      for (uint32_t k = first; k < first + uint32_t(count); ++k) {
        const uint32_t i = owen_sobol::shuffle_index(k, hash_combine(hash, p));
        out.values[2 * p][k % kSampleLanes] = owen_sobol::reversed_to_unit_float(
            owen_sobol::permute(i, hash_combine(hash, 100 + 2 * p)));
        out.values[2 * p + 1][k % kSampleLanes] = owen_sobol::reversed_to_unit_float(
            owen_sobol::permute(owen_sobol::pascal(i), hash_combine(hash, 101 + 2 * p)));
      }
    }
  }
};

// Variance over that of independent samples, both exact: 10000 seeds know it to about 1.5 %.
double ratio_to_random(const Sampler& sampler, const Integrand& integrand, double variance,
                       uint32_t count) {
  return error_curve(sampler, integrand, 10000, {count})[0] * count / variance;
}

TEST(SobolPadding, CoupledPairsAreNoWorseThanRandom) {
  const double mean = square(gauss_pair(4.0));
  const double variance = square(gauss_pair(8.0)) - mean * mean;
  const NestedShuffleOnly nested;
  EXPECT_GT(ratio_to_random(nested, {"coupled", coupled, mean, 1}, variance, 64), 1.25);
  EXPECT_GT(ratio_to_random(nested, {"signs", signs, 0.0, 1}, 1.0, 64), 1.5);
  const Integrand shadow = {"edge and shadow", edge_and_shadow, edge_and_shadow_mean(), 1};
  const double nested_shadow = ratio_to_random(nested, shadow, 1.0, 64);
  for (const StreamCount streams : {StreamCount::kOne, StreamCount::kTwo}) {
    const auto sobol = create_sampler("sobol", {streams});
    for (const uint32_t count : {16u, 64u, 256u}) {
      const double pixel_lens =
          ratio_to_random(*sobol, {"coupled", coupled, mean, 1}, variance, count);
      const double lens_time =
          ratio_to_random(*sobol, {"coupled", coupled_shuffled, mean, 1}, variance, count);
      const double fine = ratio_to_random(*sobol, {"fine signs", fine_signs, 0.0, 1}, 1.0, count);
      const double sign = ratio_to_random(*sobol, {"signs", signs, 0.0, 1}, 1.0, count);
      std::cout << "[ measured ] variance over random's, " << int(streams)
                << " stream(s), N = " << count << ": coupled " << pixel_lens << ", both shuffled "
                << lens_time << ", signs " << sign << ", fine signs " << fine << "\n";
      EXPECT_LT(pixel_lens, 1.15);
      EXPECT_LT(lens_time, 1.15);
      // Exactly 8/7: two balanced sets of four and four, matched at random inside a block of 8.
      EXPECT_NEAR(sign, 8.0 / 7.0, 0.08);
      // Without the shuffle of the blocks themselves it would be 1 + N / 64.
      EXPECT_LT(fine, 1.25);
    }
    const double shadow_gain = ratio_to_random(*sobol, shadow, 1.0, 64) / nested_shadow;
    std::cout << "[ measured ] variance over the nested shuffle's, " << int(streams)
              << " stream(s), N = 64: edge and soft shadow " << shadow_gain << "\n";
    EXPECT_LT(shadow_gain, 1.0);
  }
}

// (A - B)^2 / 4 against the true squared error of (A + B) / 2, averaged over 20000 pixels. Both
// averages have a relative deviation of about 1 to 2 %.
TEST(SobolStreams, TwoStreamsEstimateTheirErrorHonestly) {
  const Integrand integrands[] = {
      {"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 0},
      {"tilted edge", tilted_edge, 0.3 + 0.37 / 2, 0},
      {"disc", disc, 0.16 * kPiDouble, 0},
      {"4D coupled", coupled, square(gauss_pair(4.0)), 0},
      {"4D edge and shadow", edge_and_shadow, edge_and_shadow_mean(), 0},
  };
  constexpr size_t kIntegrands = std::size(integrands);
  constexpr uint32_t kCounts[] = {16, 64, 256};
  constexpr uint32_t kPixels = 20000;
  const auto sampler = create_sampler("sobol", {StreamCount::kTwo});
  double estimated[kIntegrands][3] = {}, truth[kIntegrands][3] = {};
  for (uint32_t p = 0; p < kPixels; ++p) {
    double sum[kIntegrands][2] = {};
    for_each_sample(*sampler, {p % 141, p / 141, 2}, 0, 256, [&](uint32_t k, const SlotNumbers& n) {
      for (size_t i = 0; i < kIntegrands; ++i) sum[i][(k >> 3) & 1u] += integrands[i].value(n);
      for (size_t c = 0; c < 3; ++c) {
        if (k + 1 != kCounts[c]) continue;
        for (size_t i = 0; i < kIntegrands; ++i) {
          const double a = sum[i][0] / (kCounts[c] / 2), b = sum[i][1] / (kCounts[c] / 2);
          estimated[i][c] += 0.25 * (a - b) * (a - b);
          truth[i][c] += square(0.5 * (a + b) - integrands[i].mean);
        }
      }
    });
  }
  for (size_t i = 0; i < kIntegrands; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(estimated[i][c] / truth[i][c], 1.0, 0.1)
          << integrands[i].name << " at " << kCounts[c] << " samples";
    }
  }
}

}  // namespace
}  // namespace emberline
