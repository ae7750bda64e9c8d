// Tests jitter: one sample per cell for any count, with the published spectrum and orders of
// convergence. Thresholds have a false-alarm rate of about 1e-6 per assertion. Seeds are fixed.
#include "samplers/stratified_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

#include "samplers/random_permutation.h"
#include "samplers/sample_runs.h"
#include "support/long_tests.h"
#include "unit/point_spectrum.h"
#include "unit/sample_integrands.h"

namespace emberline {
namespace {

std::unique_ptr<Sampler> jitter(uint32_t count, StreamCount streams = StreamCount::kOne) {
  return create_sampler("stratified", {streams, count});
}

// The cell of a point by definition. The rows start at y = 0, and rows with one more column come
// first.
uint32_t cell_of(double x, double y, uint32_t cells) {
  const auto rows = uint32_t(std::lround(std::sqrt(double(cells))));
  uint32_t first = 0;
  for (uint32_t row = 0; row < rows; ++row) {
    const uint32_t columns = cells / rows + (row < cells % rows ? 1 : 0);
    if (row + 1 == rows || y < double(first + columns) / cells) {
      return first + std::min(uint32_t(x * columns), columns - 1);
    }
    first += columns;
  }
  return first;
}

constexpr uint32_t kCounts[] = {1, 2, 3, 4, 5, 7, 12, 13, 16, 31, 36, 61, 64, 97, 251, 256, 1009};

// Every block of `count` samples has one sample in each cell of both planes and of all four lines.
// A float within 2^-23 of a cell's border may be rounded across it, but none of these floats is.
TEST(StratifiedSampler, EachCellHoldsOneSample) {
  for (const uint32_t count : kCounts) {
    const auto sampler = jitter(count);
    for (const uint32_t slot : {0u, 3u}) {
      std::vector<std::vector<int>> hits(6, std::vector<int>(count));
      uint32_t blocks = 0;
      for_each_sample(
          *sampler, {5, count, 1}, slot, 3 * count, [&](uint32_t k, const SlotNumbers& n) {
            for (int plane = 0; plane < 2; ++plane) {
              ++hits[size_t(plane)][cell_of(n.u[2 * plane], n.u[2 * plane + 1], count)];
            }
            for (int d = 4; d < 8; ++d) ++hits[size_t(d - 2)][size_t(double(n.u[d]) * count)];
            if ((k + 1) % count != 0) return;
            ++blocks;
            for (const auto& row : hits) {
              for (const int hit : row)
                ASSERT_EQ(hit, int(blocks)) << where("stratified", {5, count, 1}, slot, k);
            }
          });
    }
  }
}

// The same holds for each stream and its share of the samples.
TEST(StratifiedSampler, EachStreamHasItsOwnCells) {
  for (const uint32_t count : {16u, 48u, 64u, 200u, 27u}) {
    const auto sampler = jitter(count, StreamCount::kTwo);
    const uint32_t length[] = {stream_length(StreamCount::kTwo, 0, count),
                               stream_length(StreamCount::kTwo, 1, count)};
    ASSERT_EQ(length[0] + length[1], count);
    std::vector<int> hits[2] = {std::vector<int>(length[0]), std::vector<int>(length[1])};
    for_each_sample(*sampler, {8, 9, 1}, 0, count, [&](uint32_t k, const SlotNumbers& n) {
      const uint32_t stream = (k >> 3) & 1u;
      ++hits[stream][cell_of(n.u[0], n.u[1], length[stream])];
    });
    for (const auto& stream : hits) {
      for (const int hit : stream) ASSERT_EQ(hit, 1) << count << " samples";
    }
  }
}

// A sample is uniform within its cell, so the points of many pixels fill a fine grid evenly. Since
// they are stratified, the statistic stays below that of independent points.
TEST(StratifiedSampler, PrimesAreUnbiased) {
  for (const uint32_t count : {3u, 7u, 13u}) {
    const auto sampler = jitter(count);
    std::vector<uint32_t> plane(16 * 16), line(64);
    double sum = 0;
    constexpr uint32_t kPixels = 20000;
    for (uint32_t p = 0; p < kPixels; ++p) {
      for_each_sample(*sampler, {p % 128, p / 128, 9}, 1, count,
                      [&](uint32_t, const SlotNumbers& n) {
                        ++plane[size_t(n.u[2] * 16) * 16 + size_t(n.u[3] * 16)];
                        ++line[size_t(n.u[5] * 64)];
                        sum += disc(n) / (double(count) * kPixels);
                      });
    }
    EXPECT_LT(chi_square(plane), chi_square_limit(255)) << count << " samples";
    EXPECT_LT(chi_square(line), chi_square_limit(63)) << count << " samples";
    // The tolerance is 4.9 standard errors of independent samples. Jittered samples have smaller
    // errors.
    EXPECT_NEAR(sum, 0.16 * kPiDouble, 4.9 * 0.5 / std::sqrt(double(count) * kPixels));
  }
}

// With cells of width 1/s, the noise at frequency f is 1 - sinc^2(fx/s) sinc^2(fy/s) times that of
// independent points, almost zero at low frequencies (Dippe & Wold 1985).
TEST(StratifiedSampler, SpectrumMatchesJitter) {
  constexpr uint32_t kPixels = 1000;
  const auto sampler = jitter(64);
  const auto frequencies = frequency_ring(1, 7.5);
  for (const int dimension : {0, 2}) {
    const std::vector<double> power = point_spectrum(*sampler, dimension, 64, kPixels, frequencies);
    for (size_t i = 0; i < power.size(); ++i) {
      const auto sinc2 = [](int f) {
        const double x = kPiDouble * f / 8.0;
        return f == 0 ? 1.0 : square(std::sin(x) / x);
      };
      const double expected = 1.0 - sinc2(frequencies[i].first) * sinc2(frequencies[i].second);
      EXPECT_NEAR(power[i] / expected, 1.0, 5.5 / std::sqrt(double(kPixels)))
          << "frequency " << frequencies[i].first << ", " << frequencies[i].second;
    }
  }
}

// A short run takes 500 seeds, which determine a slope to .012.
TEST(StratifiedSampler, OrdersMatchJitter) {
  const Integrand integrands[] = {
      {"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 2.0},
      {"axis edge", axis_edge, kThird, 1.5},
      {"tilted edge", tilted_edge, 0.3 + 0.37 / 2, 1.5},
      {"disc", disc, 0.16 * kPiDouble, 1.5},
      {"4D coupled, padded", coupled, square(gauss_pair(4.0)), 1.0},
  };
  for (const Integrand& integrand : integrands) {
    std::vector<double> x, y;
    // The counts are primes, and squares that are not divisible by 3, as the axis edge would lie
    // between two columns.
    for (const uint32_t count : {16u, 31u, 64u, 131u, 256u, 509u, 1024u, 2039u, 4096u}) {
      const auto sampler = jitter(count);
      x.push_back(std::log(count));
      y.push_back(
          std::log(error_curve(*sampler, integrand, test::long_or_short(2000u, 500u), {count})[0]));
    }
    const double order = -slope(x, y);
    std::cout << "[ measured ] stratified, variance ~ N^-" << order << " for " << integrand.name
              << "\n";
    EXPECT_NEAR(order, integrand.order, 0.1) << integrand.name;
  }
}

TEST(RandomPermutation, IsABijectionAndTheLanesAgree) {
  for (uint32_t size = 1; size <= 300; ++size) {
    const RandomPermutation order(size, hash32(size));
    std::vector<int> hits(size);
    for (uint32_t i = 0; i < size; ++i) ++hits[order(i)];
    for (const int hit : hits) ASSERT_EQ(hit, 1) << "size " << size;
    for (uint32_t first = 0; first < size; first += 7) {
      uint32_t places[kSampleLanes];
      const int count = int(std::min(size - first, uint32_t(kSampleLanes)));
      order.places(first, count, places);
      for (int i = 0; i < count; ++i) ASSERT_EQ(places[i], order(first + uint32_t(i)));
    }
  }
}

// Over many keys, a pair of elements is mapped to every pair of positions equally often, to within
// 5 %.
TEST(RandomPermutation, PairsOfPlacesAreUniform) {
  for (const uint32_t size : {2u, 3u, 4u, 5u, 7u, 8u, 13u, 16u}) {
    for (const auto& [a, b] :
         {std::pair{0u, 1u}, std::pair{0u, size - 1}, std::pair{size / 2, 0u}}) {
      if (a == b) continue;
      std::vector<uint32_t> counts(size * size);
      for (uint32_t key = 0; key < 200 * size * size; ++key) {
        const RandomPermutation order(size, hash32(key + 77 * size));
        ++counts[order(a) * size + order(b)];
      }
      std::vector<uint32_t> pairs;
      for (uint32_t i = 0; i < size * size; ++i) {
        if (i / size != i % size) pairs.push_back(counts[i]);
      }
      const double degrees = double(pairs.size() - 1);
      const double allowance = 0.05 * 0.05 * 200 * size * size;
      EXPECT_LT(chi_square(pairs), chi_square_limit(degrees) + allowance)
          << "elements " << a << ", " << b << " of " << size;
    }
  }
}

}  // namespace
}  // namespace emberline
