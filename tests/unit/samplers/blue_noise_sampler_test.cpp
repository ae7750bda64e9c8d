// Tests blue noise: squares of pixels share nets, each pixel has a net of its own, and errors have
// high frequencies.
#include "samplers/blue_noise_sampler.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "renderer/core/errors.h"
#include "unit/sample_integrands.h"

namespace emberline {
namespace {

std::unique_ptr<Sampler> blue_noise(uint32_t count, int width, int height,
                                    StreamCount streams = StreamCount::kOne) {
  return create_sampler("blue_noise", {streams, count, width, height});
}

// Whether each elementary interval of area 2^-m, of every shape, holds one of the 2^m points.
bool is_net(const std::vector<std::pair<float, float>>& points) {
  const int m = std::countr_zero(points.size());
  for (int j = 0; j <= m; ++j) {
    std::set<std::pair<uint32_t, uint32_t>> cells;
    for (const auto& [x, y] : points) {
      cells.emplace(uint32_t(double(x) * (1u << j)), uint32_t(double(y) * (1u << (m - j))));
    }
    if (cells.size() != points.size()) return false;
  }
  return true;
}

// The union of the points in each aligned square of 1, 2, 4 or 8 pixels per side is a net, for each
// stream and each pair.
TEST(BlueNoiseSampler, AlignedSquaresShareNets) {
  for (const uint32_t count : {1u, 2u, 4u, 8u, 16u, 64u}) {
    for (const StreamCount streams : {StreamCount::kOne, StreamCount::kTwo}) {
      const auto sampler = blue_noise(count, 100, 64, streams);
      for (const uint32_t side : {1u, 2u, 4u, 8u}) {
        for (const uint32_t slot : {0u, 5u}) {
          for (int d = 0; d < kSlotDimensions; d += 2) {
            std::vector<std::pair<float, float>> points[2];
            for (uint32_t i = 0; i < side * side; ++i) {
              const PixelKey pixel{88 + i % side, 40 + i / side, 6};
              for_each_sample(*sampler, pixel, slot, count, [&](uint32_t k, const SlotNumbers& n) {
                points[streams == StreamCount::kTwo && ((k >> 3) & 1u)].emplace_back(n.u[d],
                                                                                     n.u[d + 1]);
              });
            }
            for (const auto& stream : points) {
              EXPECT_TRUE(stream.empty() || is_net(stream))
                  << count << " samples, squares of " << side << ", slot " << slot << ", dimension "
                  << d;
            }
          }
        }
      }
    }
  }
}

// Each prefix of 2^m samples of a pixel is a net in the pixel's own pair of dimensions.
TEST(BlueNoiseSampler, PrefixesOfAPixelAreNets) {
  const auto sampler = blue_noise(256, 64, 64);
  for (uint32_t p = 0; p < 100; ++p) {
    std::vector<std::pair<float, float>> points;
    for_each_sample(*sampler, {p % 64, p / 64, 1}, 0, 256, [&](uint32_t k, const SlotNumbers& n) {
      points.emplace_back(n.u[0], n.u[1]);
      if (std::has_single_bit(k + 1)) {
        ASSERT_TRUE(is_net(points)) << k + 1 << " samples";
      }
    });
  }
}

// The error of the mean in each pixel of a frame of kSide^2 pixels. All pixels have the same
// integrand of the numbers of `slot`.
constexpr int kSide = 128;
std::vector<double> error_image(const Sampler& sampler, const Integrand& integrand, uint32_t slot,
                                uint32_t count) {
  std::vector<double> image(kSide * kSide);
  for (uint32_t i = 0; i < image.size(); ++i) {
    for_each_sample(
        sampler, {i % kSide, i / kSide, 31}, slot, count,
        [&](uint32_t, const SlotNumbers& n) { image[i] += integrand.value(n) / count; });
    image[i] -= integrand.mean;
  }
  return image;
}

// The power at frequencies of 1 to kSide / 16 cycles per frame (wavelengths of 16 pixels or more),
// divided by the mean power. White noise has 1, which is known to 10 % (about 100 frequencies, each
// exponential).
double low_frequency_share(const std::vector<double>& image) {
  constexpr int kHighest = kSide / 16;
  double total = 0, low = 0;
  int frequencies = 0;
  for (const double value : image) total += value * value;
  for (int fx = 0; fx <= kHighest; ++fx) {
    std::vector<std::complex<double>> row(kSide);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        row[size_t(y)] += image[size_t(y * kSide + x)] *
                          std::polar(1.0, -2.0 * std::numbers::pi * fx * x / kSide);
      }
    }
    for (int fy = fx == 0 ? 1 : -kHighest; fy <= kHighest; ++fy) {
      if (std::hypot(fx, fy) > kHighest) continue;
      std::complex<double> sum = 0;
      for (int y = 0; y < kSide; ++y) {
        sum += row[size_t(y)] * std::polar(1.0, -2.0 * std::numbers::pi * fy * y / kSide);
      }
      low += std::norm(sum);
      ++frequencies;
    }
  }
  return low / frequencies / total;
}

TEST(BlueNoiseSampler, ErrorIsInTheHighFrequencies) {
  const Integrand integrands[] = {
      {"smooth", smooth, (std::numbers::e - 1.0) / 3.0, 0},
      {"tilted edge", tilted_edge, 0.3 + 0.37 / 2, 0},
      {"disc", disc, 0.16 * kPiDouble, 0},
  };
  for (const uint32_t count : {1u, 4u, 16u}) {
    const auto white = create_sampler("sobol", {});
    for (const Integrand& integrand : integrands) {
      EXPECT_NEAR(low_frequency_share(error_image(*white, integrand, 0, count)), 1.0, 0.5);
      for (const uint32_t slot : {0u, 2u}) {
        const auto sampler = blue_noise(count, kSide, kSide);
        const double share = low_frequency_share(error_image(*sampler, integrand, slot, count));
        std::cout << "[ measured ] blue_noise, " << count << " samples, slot " << slot << ", "
                  << integrand.name << ": low frequencies have " << share << " of white noise's\n";
        EXPECT_LT(share, 0.4);
      }
    }
  }
}

// If one sequence is too short for the frame, each tile has a sequence of its own.
TEST(BlueNoiseSampler, LargeFramesAreCutIntoTiles) {
  constexpr uint32_t kCount = 1u << 24;  // 2^32 points are enough for 16 x 16 of these pixels
  const auto sampler = blue_noise(kCount, 65536, 65536);
  std::set<float> seen;
  for (uint32_t tile = 0; tile < 64; ++tile) {
    seen.insert(read_sample(*sampler, {16 * tile, 48, 2}, 1, 77).u[0]);
  }
  EXPECT_EQ(seen.size(), 64u);
}

TEST(BlueNoiseSampler, OtherCountsAreRefused) {
  try {
    blue_noise(48, 16, 16);
    FAIL() << "accepted 48 samples";
  } catch (const UsageError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("spp: 48 is not a power of two"), 0u) << text;
    EXPECT_NE(text.find("sampler blue_noise"), std::string::npos) << text;
    EXPECT_NE(text.find("32 and 64"), std::string::npos) << text;
  }
  for (uint32_t count = 1; count <= 1u << 24; count *= 2) EXPECT_NO_THROW(blue_noise(count, 9, 9));
}

}  // namespace
}  // namespace emberline
