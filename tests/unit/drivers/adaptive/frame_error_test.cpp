// Tests the error of a whole frame in cases where it is known.
#include "renderer/drivers/adaptive/frame_error.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "renderer/core/display_error.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/missed_light.h"
#include "unit/synthetic_pixels.h"

namespace emberline::test {
namespace {

// The noise is normal with .05 per sample about .3, where the display curve is almost straight, so
// the error is slope times .05 / sqrt(n). The mean of 9216 squares with one degree of freedom is
// known to 1.5 %, and its root to half of that.
TEST(FrameError, IsTheDeviationOfTheMeans) {
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  for (const uint32_t n : {16u, 64u}) {
    const PixelStatistics pixels = drawn_pixels(
        96, 96, n, 5, [](TestRandom& random) { return 0.3 + 0.05 * draw_normal(random); });
    const double expected = slope * 0.05 / std::sqrt(n);
    EXPECT_NEAR(frame_error(pixels), expected, 0.03 * expected) << n << " samples";
  }
}

// With eight samples there is only one stream so far.
TEST(FrameError, WithoutASecondStreamAsIfIndependent) {
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  const PixelStatistics pixels = drawn_pixels(
      96, 96, 8, 5, [](TestRandom& random) { return 0.3 + 0.05 * draw_normal(random); });
  const double expected = slope * 0.05 / std::sqrt(8.0);
  EXPECT_NEAR(frame_error(pixels), expected, 0.03 * expected);
}

// The noise of a pixel is weighted at the pixel's own value. Clipped noise is invisible, whatever
// the neighbours show.
TEST(FrameError, LampNoiseDoesNotSpreadToDarkNeighbours) {
  PixelStatistics pixels = constant_pixels(64, 64, 0.0f, 64.0f);
  for (size_t i = 0; i < pixels.size(); i += 2) {
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][i] = 20.0f;
      pixels.stream_difference[c][i] = 2.0f;  // the mean of both has a quarter of its square
    }
  }
  EXPECT_LT(frame_error(pixels), 0.02);
  // The same noise at mid grey is visible.
  for (size_t i = 0; i < pixels.size(); i += 2) {
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][i] = 0.3f;
      pixels.stream_difference[c][i] = 0.02f;
    }
  }
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  EXPECT_NEAR(frame_error(pixels), slope * 0.01 / std::sqrt(2.0), 2e-4);
}

double true_error(const PixelStatistics& pixels, double mean) {
  double sum = 0;
  for (const auto& channel : pixels.mean) {
    for (const float value : channel) {
      const double error = double(display_value(value)) - double(display_value(float(mean)));
      sum += error * error;
    }
  }
  return std::sqrt(sum / (3.0 * double(pixels.size())));
}

double with_missed(const PixelStatistics& pixels) {
  return frame_error(pixels, missed_light_error(pixels));
}

// One sample in 1,000 hits a lamp, and the lamp makes the true picture white. Almost all pixels
// look dark and certain, and are wrong.
TEST(FrameError, TellsOfLampsThatFewPixelsHaveMet) {
  constexpr double kChance = 1e-3, kLamp = 1000.0, kDark = 0.02;
  for (const uint32_t n : {16u, 64u, 256u}) {
    const PixelStatistics pixels = drawn_pixels(96, 96, n, n, [](TestRandom& random) {
      return kDark + (random.next_double() < kChance ? kLamp : 0.0);
    });
    const double truth = true_error(pixels, kDark + kChance * kLamp);
    EXPECT_LT(frame_error(pixels), 0.6 * truth) << n << " samples: the test says nothing";
    // With 16 samples, most neighbourhoods have not hit the lamp either.
    EXPECT_GT(with_missed(pixels), (n < 64 ? 0.4 : 0.6) * truth) << n << " samples";
    EXPECT_LT(with_missed(pixels), 1.25 * truth) << n << " samples";
    std::printf("  lamps, %u: %.2f of the truth, %.2f without\n", n, with_missed(pixels) / truth,
                frame_error(pixels) / truth);
  }
}

// The samples are log-normal with mean .2. With a sigma of 2.5 the deviation is 23 times the mean,
// and with .5 the samples are almost normal.
TEST(FrameError, LogNormalSamplesGiveTheTrueError) {
  for (const double sigma : {0.5, 1.5, 2.5}) {
    for (const uint32_t n : {16u, 64u, 256u}) {
      const PixelStatistics pixels = drawn_pixels(96, 96, n, n, [&](TestRandom& random) {
        return 0.2 * std::exp(sigma * draw_normal(random) - sigma * sigma / 2);
      });
      const double ratio = with_missed(pixels) / true_error(pixels, 0.2);
      EXPECT_GT(ratio, 0.8) << "sigma " << sigma << ", " << n << " samples";
      EXPECT_LT(ratio, 1.25) << "sigma " << sigma << ", " << n << " samples";
      std::printf("  sigma %.1f, %u: %.2f of the truth\n", sigma, n, ratio);
    }
  }
}

// Half the samples of a pixel that shows a lamp hit it, and the lamp's edge is sharp. So the dark
// pixels next to it must not count as having missed light. With 6 samples the lamp's mean could be
// that of the dark pixels, but its samples show that they would have hit it.
TEST(FrameError, AddsNothingNextToALampInFocus) {
  for (const float samples : {6.0f, 32.0f}) {
    PixelStatistics pixels = constant_pixels(64, 64, 0.05f, samples);
    for (size_t i = 0; i < pixels.size(); i += 9) {
      for (size_t c = 0; c < 3; ++c) {
        pixels.mean[c][i] = 50.0f;
        pixels.variance[c][i] = 2500.0f;
        pixels.stream_difference[c][i] = 100.0f / std::sqrt(samples);  // follows from that variance
      }
    }
    EXPECT_LT(missed_light_error(pixels), (samples < 32 ? 0.25 : 1e-3) * double(pixels.size()));
  }
}

// Every third of the dark pixels beside an edge has met a lamp once in 64 samples. The bright
// pixels behind the edge must not hide that the others have missed it.
TEST(FrameError, BrightPixelsBehindAnEdgeDoNotHideMissedLight) {
  const auto frame_with = [](float right_half) {
    constexpr int kWidth = 64, kHeight = 48;
    constexpr float kSamples = 64.0f;
    PixelStatistics pixels = constant_pixels(kWidth, kHeight, 0.03f, kSamples);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool found = x == kWidth / 2 - 1 && y % 3 == 0;
        for (size_t c = 0; c < 3; ++c) {
          const size_t i = size_t(y * kWidth + x);
          if (x >= kWidth / 2) {
            pixels.mean[c][i] = right_half;
            pixels.variance[c][i] = right_half;
            pixels.stream_difference[c][i] = std::sqrt(right_half * 4 / kSamples);
          }
          if (!found) continue;
          pixels.mean[c][i] = 2.0f;  // one sample of 128
          pixels.variance[c][i] = square(2.0f) * kSamples;
          pixels.stream_difference[c][i] = 4.0f;
        }
      }
    }
    return pixels;
  };
  const double alone = missed_light_error(frame_with(0.03f));
  const double beside_edge = missed_light_error(frame_with(500.0f));
  EXPECT_GT(alone, 1.0);
  EXPECT_GT(beside_edge, 0.5 * alone);
  EXPECT_LT(beside_edge, 1.1 * alone);
}

// All pixels have the same mean, so none has found more light than another. The widths are not
// multiples of the number of pixels that are computed together.
TEST(FrameError, EqualPixelsHaveMissedNothing) {
  for (const auto& [width, height] : {std::pair(1, 1), {3, 2}, {20, 8}, {1, 33}, {173, 5}}) {
    PixelStatistics pixels = constant_pixels(width, height, 0.1f, 16.0f);
    for (auto& channel : pixels.variance) std::ranges::fill(channel, 0.04f);
    EXPECT_EQ(missed_light_error(pixels), 0.0) << width << " x " << height;
  }
}

TEST(FrameError, IsTheSameForAnyNumberOfThreads) {
  const PixelStatistics pixels = drawn_pixels(173, 91, 16, 3, [](TestRandom& random) {
    return random.next_double() < 0.01 ? 20.0 : 0.1 * random.next_double();
  });
  const auto errors_with = [&](int threads) {
    return tbb::task_arena(threads).execute([&] {
      const double missed = missed_light_error(pixels);
      return std::pair(missed, frame_error(pixels, missed));
    });
  };
  EXPECT_EQ(errors_with(1), errors_with(3));
  EXPECT_GT(errors_with(1).first, 0.0);
}

// A frame may have any scale of light, and rows without noise.
TEST(FrameError, IsFiniteAtAnyScale) {
  for (int exponent = -40; exponent <= 40; exponent += 5) {
    const double scale = std::ldexp(1.0, exponent);
    PixelStatistics pixels = drawn_pixels(40, 30, 16, 4, [&](TestRandom& random) {
      return random.next_double() < 0.01 ? 1e3 * scale : scale * random.next_double();
    });
    for (size_t c = 0; c < 3; ++c) {
      for (size_t x = 0; x < 40; ++x) {
        pixels.mean[c][x] = float(scale);
        pixels.variance[c][x] = pixels.stream_difference[c][x] = 0.0f;
      }
    }
    const double missed = missed_light_error(pixels);
    EXPECT_TRUE(std::isfinite(missed) && missed >= 0.0) << exponent;
    EXPECT_TRUE(std::isfinite(frame_error(pixels, missed))) << exponent;
  }
}

TEST(FrameError, EmptyAndNonFiniteFramesGiveFiniteErrors) {
  EXPECT_EQ(frame_error({}), 0.0);
  EXPECT_EQ(missed_light_error({}), 0.0);
  PixelStatistics pixels = constant_pixels(8, 8, 0.5f, 16.0f);
  EXPECT_EQ(frame_error(pixels), 0.0);
  pixels.stream_difference[1][7] = std::numeric_limits<float>::infinity();
  pixels.variance[1][7] = std::numeric_limits<float>::infinity();
  pixels.mean[2][9] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isfinite(frame_error(pixels)));
  EXPECT_TRUE(std::isfinite(with_missed(pixels)));
}

}  // namespace
}  // namespace emberline::test
