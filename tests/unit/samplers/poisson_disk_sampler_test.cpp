// Tests Poisson disk points. Every prefix keeps its minimum distance and has little low-frequency
// noise, and no two pairs of a pixel are copies of each other.
#include "samplers/poisson_disk_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <vector>

#include "renderer/core/vector.h"
#include "samplers/sample_runs.h"
#include "support/long_tests.h"
#include "unit/point_spectrum.h"

namespace emberline {
namespace {

constexpr uint32_t kTableSize = 1024;

struct Point {
  double x, y;
};

double torus_distance(const Point& a, const Point& b) {
  const double dx = std::remainder(a.x - b.x, 1.0), dy = std::remainder(a.y - b.y, 1.0);
  return std::hypot(dx, dy);
}

// The minimum distance of n points is a fraction of that of the hexagonal lattice, less rounding.
double min_distance(uint32_t n) {
  return kPoissonDiskRadius * std::sqrt(2.0 / std::sqrt(3.0) / n) - 1e-6;
}

// Returns the points of one stream in one pair of dimensions.
std::vector<Point> points(StreamCount streams, uint32_t stream, const PixelKey& pixel,
                          uint32_t slot, int dimension, uint32_t count) {
  const auto sampler = create_sampler("poisson_disk", {streams});
  std::vector<Point> result;
  for_each_sample(*sampler, pixel, slot, 2 * count, [&](uint32_t k, const SlotNumbers& n) {
    if (stream_index(streams, k).stream == stream && result.size() < count) {
      result.push_back({n.u[dimension], n.u[dimension + 1]});
    }
  });
  return result;
}

TEST(PoissonDiskSampler, EveryPrefixKeepsItsDistance) {
  for (const StreamCount streams : {StreamCount::kOne, StreamCount::kTwo}) {
    for (uint32_t slot = 0; slot < 4; ++slot) {
      for (const int dimension : {0, 2}) {
        const PixelKey pixel{17 * slot, 3, 4};
        const uint32_t stream = streams == StreamCount::kTwo ? 1 : 0;
        const auto p = points(streams, stream, pixel, slot, dimension, kTableSize);
        double least = 1;
        for (uint32_t i = 1; i < kTableSize; ++i) {
          for (uint32_t j = 0; j < i; ++j) least = std::min(least, torus_distance(p[i], p[j]));
          ASSERT_GE(least, min_distance(i + 1))
              << "of the first " << i + 1 << ", " << where("poisson_disk", pixel, slot, i);
        }
      }
    }
  }
}

// There is little noise at frequencies below that of the samples (Dippe & Wold 1985). The average
// of each ring, over 50 pixels and dozens of frequencies, is known to a few per cent.
TEST(PoissonDiskSampler, LowFrequenciesAreQuiet) {
  const uint32_t pixels = test::long_or_short(50u, 15u);
  const auto sampler = create_sampler("poisson_disk", {});
  for (const int dimension : {0, 2}) {
    for (const uint32_t count : {16u, 50u, 64u, 256u, 1000u}) {
      // The rings are in units of the hexagonal lattice's frequency, the inverse of its row
      // spacing.
      const double lattice = std::sqrt(2.0 / std::sqrt(3.0) * count);
      const double low = average(
          point_spectrum(*sampler, dimension, count, pixels, frequency_ring(1, 0.4 * lattice)));
      const double peak = average(point_spectrum(*sampler, dimension, count, pixels,
                                                 frequency_ring(0.95 * lattice, 1.15 * lattice)));
      std::cout << "[ measured ] poisson_disk, dimension " << dimension << ", " << count
                << " samples: power " << low << " up to 0.4 of the lattice's frequency, " << peak
                << " around it\n";
      EXPECT_LT(low, 0.15);
      EXPECT_GT(peak, 1.2);
    }
  }
}

// The differences between the points of two pairs are random: no pair is a shifted, mirrored or
// transposed copy of another pair.
TEST(PoissonDiskSampler, NoPairCopiesAnother) {
  for (const PixelKey pixel : {PixelKey{1, 2, 3}, PixelKey{40, 2, 3}, PixelKey{9, 9, 0}}) {
    std::vector<std::vector<Point>> sets;
    for (uint32_t slot = 0; slot < 4; ++slot) {
      for (const int dimension : {0, 2}) {
        sets.push_back(points(StreamCount::kOne, 0, pixel, slot, dimension, 512));
      }
    }
    for (size_t a = 0; a < sets.size(); ++a) {
      for (size_t b = 0; b < a; ++b) {
        for (int symmetry = 0; symmetry < 8; ++symmetry) {
          std::vector<uint32_t> counts(64);
          for (size_t i = 0; i < sets[a].size(); ++i) {
            Point q = sets[b][i];
            if (symmetry & 1) q.x = 1 - q.x;
            if (symmetry & 2) q.y = 1 - q.y;
            if (symmetry & 4) std::swap(q.x, q.y);
            const auto wrapped = [](double x) { return std::min(7.0, 8 * (x - std::floor(x))); };
            ++counts[size_t(wrapped(sets[a][i].x - q.x)) * 8 + size_t(wrapped(sets[a][i].y - q.y))];
          }
          EXPECT_LT(chi_square(counts), chi_square_limit(63))
              << "pairs " << a << " and " << b << " of pixel " << pixel.x << ", " << pixel.y;
        }
      }
    }
  }
}

// After the end of a table, the same points return with a different shift.
TEST(PoissonDiskSampler, TheNextTableIsAnother) {
  const auto p = points(StreamCount::kOne, 0, {6, 7, 8}, 0, 0, 2 * kTableSize);
  std::vector<uint32_t> counts(64);
  for (uint32_t i = 0; i < kTableSize; ++i) {
    ++counts[size_t(p[kTableSize + i].x * 8) * 8 + size_t(p[kTableSize + i].y * 8)];
    EXPECT_GT(torus_distance(p[i], p[kTableSize + i]), 0.0);
  }
  EXPECT_LT(chi_square(counts), chi_square_limit(63));
}

}  // namespace
}  // namespace emberline
