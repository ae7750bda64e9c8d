// The error of a whole frame, where it is known.
#include "renderer/drivers/adaptive/frame_error.h"

#include <gtest/gtest.h>

#include <limits>

#include "renderer/drivers/adaptive/error_metric.h"
#include "unit/synthetic_pixels.h"

namespace emberline::test {
namespace {

// Normal noise of .05 a sample about .3, where the display's curve is almost straight: slope times
// .05 / sqrt(n). Of 9216 squares of one degree of freedom the mean is known to 1.5 %, its root to
// half of that.
TEST(FrameError, IsTheDeviationOfTheMeans) {
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  for (const uint32_t n : {16u, 64u}) {
    const PixelStatistics pixels = drawn_pixels(
        96, 96, n, 5, [](TestRandom& random) { return 0.3 + 0.05 * draw_normal(random); });
    const double expected = slope * 0.05 / std::sqrt(n);
    EXPECT_NEAR(frame_error(pixels), expected, 0.03 * expected) << n << " samples";
  }
}

// One stream yet: eight samples.
TEST(FrameError, WithoutASecondStreamAsIfIndependent) {
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  const PixelStatistics pixels = drawn_pixels(
      96, 96, 8, 5, [](TestRandom& random) { return 0.3 + 0.05 * draw_normal(random); });
  const double expected = slope * 0.05 / std::sqrt(8.0);
  EXPECT_NEAR(frame_error(pixels), expected, 0.03 * expected);
}

// A pixel's noise is weighed where the pixel is: what is clipped is not seen, whatever is beside
// it.
TEST(FrameError, NoiseOfALampIsNotThatOfTheDarknessBesideIt) {
  PixelStatistics pixels = constant_pixels(64, 64, 0.0f, 64.0f);
  for (size_t i = 0; i < pixels.size(); i += 2) {
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][i] = 20.0f;
      pixels.stream_difference[c][i] = 2.0f;  // a quarter of its square for the mean of both
    }
  }
  EXPECT_LT(frame_error(pixels), 0.02);
  // The same noise at mid grey.
  for (size_t i = 0; i < pixels.size(); i += 2) {
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][i] = 0.3f;
      pixels.stream_difference[c][i] = 0.02f;
    }
  }
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  EXPECT_NEAR(frame_error(pixels), slope * 0.01 / std::sqrt(2.0), 2e-4);
}

TEST(FrameError, OfNothingAndOfNothingFiniteIsFinite) {
  EXPECT_EQ(frame_error({}), 0.0);
  PixelStatistics pixels = constant_pixels(8, 8, 0.5f, 16.0f);
  EXPECT_EQ(frame_error(pixels), 0.0);
  pixels.stream_difference[1][7] = 1e30f;
  pixels.variance[1][7] = 1e30f;
  EXPECT_TRUE(std::isfinite(frame_error(pixels)));
}

}  // namespace
}  // namespace emberline::test
