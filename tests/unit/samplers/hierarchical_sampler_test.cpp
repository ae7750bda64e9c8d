// Rebuilds Kajiya's tree from the points alone. Each sample goes to the emptier side, and the
// weights of hierarchical integration are the volumes of the leaves.
#include "samplers/hierarchical_sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <iostream>
#include <map>
#include <numbers>
#include <vector>

#include "samplers/sample_runs.h"
#include "support/long_tests.h"
#include "unit/sample_integrands.h"

namespace emberline {
namespace {

constexpr int kTreeDimensions = 5;
constexpr StreamCount kBoth[] = {StreamCount::kOne, StreamCount::kTwo};

using TreePoint = std::array<float, kTreeDimensions>;

std::vector<TreePoint> tree_points(StreamCount streams, uint32_t stream, const PixelKey& pixel,
                                   uint32_t count) {
  const auto sampler = create_sampler("hierarchical", {streams});
  std::vector<TreePoint> points;
  for_each_sample(*sampler, pixel, 0, 2 * count + 16, [&](uint32_t k, const SlotNumbers& n) {
    if (stream_index(streams, k).stream != stream || points.size() == count) return;
    points.push_back({n.u[0], n.u[1], n.u[2], n.u[3], n.u[4]});
  });
  return points;
}

// The node at `depth` that contains the point. Depth b halves dimension b % 5 for the (b / 5 +
// 1)-th time. A node's name is its path with a leading 1, so the root is 1.
uint32_t node_at(const TreePoint& point, int depth) {
  uint32_t node = 1;
  for (int b = 0; b < depth; ++b) {
    const auto digits = uint32_t(double(point[size_t(b % kTreeDimensions)]) * 0x1p24);
    node = 2 * node + ((digits >> (23 - b / kTreeDimensions)) & 1u);
  }
  return node;
}

TEST(HierarchicalSampler, EachSampleGoesToTheEmptierSide) {
  for (const StreamCount streams : kBoth) {
    for (uint32_t pixel = 0; pixel < 20; ++pixel) {
      const auto points = tree_points(streams, 0, {pixel, 5, 6}, 1024);
      std::map<uint32_t, int> held;
      for (uint32_t k = 0; k < points.size(); ++k) {
        for (int depth = 0; depth < 12; ++depth) ++held[node_at(points[k], depth)];
        for (int depth = 0; depth < 11; ++depth) {
          const uint32_t node = node_at(points[k], depth);
          ASSERT_LE(std::abs(held[2 * node] - held[2 * node + 1]), 1)
              << where("hierarchical", {pixel, 5, 6}, 0, k) << ", depth " << depth;
        }
        if (!std::has_single_bit(k + 1)) continue;
        const int level = std::countr_zero(k + 1);
        for (uint32_t cell = k + 1; cell < 2 * (k + 1); ++cell) {
          ASSERT_EQ(held[cell], 1) << "level " << level;
        }
      }
    }
  }
}

// The coins are fair, and the coins of two nodes on one level are independent. The first 4 samples
// of a pixel visit the four cells in one of 8 orders, which are equally frequent over many pixels.
TEST(HierarchicalSampler, CoinsAreFair) {
  std::map<uint32_t, uint32_t> orders;
  for (uint32_t pixel = 0; pixel < 8000; ++pixel) {
    uint32_t order = 0;
    for (const TreePoint& point :
         tree_points(StreamCount::kOne, 0, {pixel % 97, pixel / 97, 1}, 4)) {
      order = 4 * order + node_at(point, 2) % 4;
    }
    ++orders[order];
  }
  ASSERT_EQ(orders.size(), 8u);
  std::vector<uint32_t> counts;
  for (const auto& [order, count] : orders) counts.push_back(count);
  EXPECT_LT(chi_square(counts), chi_square_limit(7));
}

// The weight is the stream's count times the volume of the leaf. A search finds the depth at which
// a sample is alone.
TEST(HierarchicalSampler, WeightsAreTheLeavesVolumes) {
  for (const StreamCount streams : kBoth) {
    const auto sampler = create_sampler("hierarchical", {streams});
    const std::vector<TreePoint> points[] = {tree_points(streams, 0, {3, 1, 4}, 130),
                                             tree_points(streams, 1, {3, 1, 4}, 130)};
    for (uint32_t count = 1; count <= 130; ++count) {
      double sum = 0;
      for (uint32_t k = 0; k < count; ++k) {
        const auto [stream, index] = stream_index(streams, k);
        const uint32_t length = stream_length(streams, stream, count);
        int depth = 0;
        const auto shared = [&] {
          int held = 0;
          for (uint32_t i = 0; i < length; ++i) {
            held += node_at(points[stream][i], depth) == node_at(points[stream][index], depth);
          }
          return held > 1;
        };
        while (shared()) ++depth;
        const float weight = sampler->integration_weight(k, count);
        ASSERT_EQ(weight, float(length) * std::ldexp(1.0f, -depth)) << k << " of " << count;
        sum += weight;
      }
      ASSERT_NEAR(sum, count, 1e-4 * count);
    }
  }
  EXPECT_EQ(create_sampler("sobol", {})->integration_weight(3, 5), 1.0f);
}

double smooth_in_five(const SlotNumbers& n) {
  double product = 1;
  for (int d = 0; d < kTreeDimensions; ++d) product *= 0.5 + n.u[d];
  return product;
}
// An edge that moves while the shutter is open.
double moving_edge(const SlotNumbers& n) { return n.u[0] < 0.25f + 0.5f * n.u[4] ? 1.0 : 0.0; }
// A checkerboard far finer than the leaves.
double noise(const SlotNumbers& n) { return int(n.u[0] * 4096.0f) & 1 ? 1.0 : -1.0; }

struct Errors {
  double plain, weighted, signed_error, deviation;
};

Errors measure(const Sampler& sampler, const Integrand& integrand, uint32_t count,
               uint32_t pixels) {
  Errors errors{};
  for (uint32_t p = 0; p < pixels; ++p) {
    double plain = 0, weighted = 0;
    for_each_sample(sampler, {p % 200, p / 200, 77}, 0, count,
                    [&](uint32_t k, const SlotNumbers& n) {
                      const double value = integrand.value(n) / count;
                      plain += value;
                      weighted += value * double(sampler.integration_weight(k, count));
                    });
    errors.plain += square(plain - integrand.mean) / pixels;
    errors.weighted += square(weighted - integrand.mean) / pixels;
    errors.signed_error += (weighted - integrand.mean) / pixels;
  }
  errors.deviation = std::sqrt(errors.weighted / pixels);
  return errors;
}

TEST(HierarchicalSampler, HierarchicalIntegrationIsUnbiased) {
  const Integrand integrands[] = {
      {"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 0},
      {"smooth in 5D", smooth_in_five, 1.0, 0},
      {"axis edge", axis_edge, kThird, 0},
      {"disc", disc, 0.16 * kPiDouble, 0},
      {"moving edge", moving_edge, 0.5, 0},
      {"coupled", coupled, square(gauss_pair(4.0)), 0},
  };
  const auto sampler = create_sampler("hierarchical", {});
  for (const Integrand& integrand : integrands) {
    std::cout << "[ measured ] variance of hierarchical integration over the plain mean's, "
              << integrand.name << ":";
    for (const uint32_t count : {12u, 24u, 48u, 80u, 96u, 112u, 128u}) {
      const Errors errors = measure(*sampler, integrand, count, test::long_or_short(20000, 5000));
      std::cout << " N = " << count << " " << errors.weighted / errors.plain;
      EXPECT_LT(std::abs(errors.signed_error), 4.9 * errors.deviation)
          << integrand.name << ", " << count << " samples";
      if (std::has_single_bit(count)) {
        EXPECT_EQ(errors.weighted, errors.plain);
      }
    }
    std::cout << "\n";
  }
}

// Detail that the tree does not resolve is independent noise. With n = 2^m (1 + t) samples, there
// are 2^m (1 - t) leaves of volume 2^-m and 2^m 2t leaves of half this volume. The variance is then
// (1 + t)(1 - t/2) times that of equal weights. Both variances are known to 1 % and share their
// samples.
TEST(HierarchicalSampler, HierarchicalIntegrationOfNoiseCostsItsShare) {
  const auto sampler = create_sampler("hierarchical", {});
  for (const uint32_t count : {3u, 6u, 20u, 24u, 96u, 112u}) {
    const double t = double(count) / std::bit_floor(count) - 1.0;
    const Errors errors = measure(*sampler, {"noise", noise, 0.0, 0}, count, 20000);
    EXPECT_NEAR(errors.weighted / errors.plain, (1 + t) * (1 - t / 2), 0.03) << count;
  }
}

// The weights pay where the last halvings matter. Here the sixth and the seventh halving are those
// of the pixel's two dimensions.
TEST(HierarchicalSampler, HierarchicalIntegrationPaysWhereTheLastHalvingMatters) {
  const auto sampler = create_sampler("hierarchical", {});
  const Integrand integrand = {"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 0};
  for (const uint32_t count : {80u, 96u, 112u}) {
    const Errors errors = measure(*sampler, integrand, count, 20000);
    EXPECT_LT(errors.weighted, 0.95 * errors.plain) << count;
  }
}

}  // namespace
}  // namespace emberline
