#include "renderer/statistics/flicker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/core/hash.h"

namespace emberline {
namespace {

constexpr int kColumns = 40, kRows = 25;
constexpr size_t kPixels = size_t(kColumns) * kRows;

RgbImage filled(float value) { return {kColumns, kRows, std::vector<float>(3 * kPixels, value)}; }

// Noise of variance amplitude^2 around 1.
RgbImage noisy(uint32_t seed, float amplitude) {
  RgbImage image = filled(1);
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    const float u = to_unit_float(hash_combine(hash32(seed), uint32_t(i)));
    image.rgb[i] += amplitude * std::sqrt(12.0f) * (u - 0.5f);
  }
  return image;
}

PixelMotion moving(float right, float down) {
  return {std::vector<float>(kPixels, right), std::vector<float>(kPixels, down)};
}

// Moves a picture right and down by whole pixels.
RgbImage moved(const RgbImage& image, int right, int down) {
  RgbImage result = filled(1);
  for (int y = down; y < kRows; ++y) {
    for (int x = right; x < kColumns; ++x) {
      for (int c = 0; c < 3; ++c) {
        result.rgb[size_t(3 * (y * kColumns + x) + c)] =
            image.rgb[size_t(3 * ((y - down) * kColumns + x - right) + c)];
      }
    }
  }
  return result;
}

double value(const SequenceFrame& frame, const SequenceFrame& next, double epsilon = 0) {
  return flicker(frame, next, epsilon).value;
}

const RgbImage kReference = filled(1);
const PixelMotion kStill;

// 3,000 values with a standard error of 2.5 %; the mean of the trimmed values is a little less.
TEST(Flicker, IndependentNoiseGivesTheSumOfBothErrors) {
  const RgbImage a = noisy(1, 0.1f), b = noisy(2, 0.2f);
  EXPECT_NEAR(value({a, kReference, kStill}, {b, kReference, kStill}), 0.05, 0.004);
}

TEST(Flicker, AConstantErrorDoesNotFlicker) {
  const RgbImage a = noisy(1, 0.1f);
  EXPECT_EQ(value({a, kReference, kStill}, {a, kReference, kStill}), 0);
  // A change of the scene itself is no error.
  RgbImage brighter = a, reference = filled(1.5f);
  for (float& value : brighter.rgb) value *= 1.5f;
  EXPECT_NEAR(value({a, kReference, kStill}, {brighter, reference, kStill}), 0, 1e-12);
}

TEST(Flicker, FollowsTheMotion) {
  const RgbImage a = noisy(1, 0.1f), b = moved(a, 3, 2);
  const PixelMotion motion = moving(3.2f, 1.9f);
  EXPECT_EQ(value({a, kReference, motion}, {b, kReference, motion}), 0);
  EXPECT_GT(value({a, kReference, kStill}, {b, kReference, kStill}), 0.015);
}

TEST(Flicker, EachErrorIsRelativeToItsOwnReference) {
  const RgbImage zero = filled(0), two = filled(2), three = filled(3);
  EXPECT_NEAR(value({two, two, kStill}, {three, two, kStill}, 1), 1 / 5.0, 1e-12);
  EXPECT_NEAR(value({zero, zero, kStill}, {two, zero, kStill}, 0.5), 4 / 0.5, 1e-12);
  // A dark pixel before a bright one: the noise of the bright one counts as that of the bright one.
  RgbImage bright = noisy(2, 0.1f), ten = filled(10);
  for (float& value : bright.rgb) value *= 10;
  EXPECT_NEAR(value({noisy(1, 0.1f), kReference, kStill}, {bright, ten, kStill}), 0.02, 0.002);
}

TEST(Flicker, CurvedMotionIsMeasured) {
  // A point that turns by 12 degrees a frame.
  const RgbImage a = noisy(1, 0.1f);
  const Flicker measured =
      flicker({a, kReference, moving(10, 0)}, {a, kReference, moving(9.8f, 2.1f)}, 0);
  EXPECT_NEAR(measured.share, 0.75, 1e-9);  // a quarter of the columns leaves the picture
}

TEST(Flicker, SkipsWhatLeavesOrIsCoveredAndWhatIsNotFinite) {
  const RgbImage right = filled(1);
  RgbImage wrong = filled(1);
  // Column 5 of the next frame is covered by something that stands still.
  PixelMotion next = moving(1, 0);
  for (int y = 0; y < kRows; ++y) {
    next.right[size_t(y * kColumns + 5)] = -1;
    for (int c = 0; c < 3; ++c) wrong.rgb[size_t(3 * (y * kColumns + 5) + c)] = 9;
  }
  EXPECT_EQ(value({right, kReference, moving(1, 0)}, {wrong, kReference, next}), 0);
  wrong = filled(1);
  wrong.rgb[10] = std::numeric_limits<float>::quiet_NaN();
  wrong.rgb[20] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(value({right, kReference, kStill}, {wrong, kReference, kStill}), 0);
  for (const float far : {1000.0f, 1e30f, std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()}) {
    const PixelMotion away = moving(far, 0);
    EXPECT_TRUE(std::isnan(value({right, kReference, away}, {right, kReference, away}))) << far;
  }
}

}  // namespace
}  // namespace emberline
