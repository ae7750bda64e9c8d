#include "renderer/session/grading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "io/image/output.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

// Returns the bytes that an image file gets.
std::vector<uint8_t> expected(const DisplaySettings& settings, const std::vector<float>& rgba) {
  const DisplayTransform transform(settings);
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i < rgba.size(); i += 4) {
    float rgb[3] = {rgba[i], rgba[i + 1], rgba[i + 2]};
    transform.apply(rgb, 1);
    for (const float value : rgb) bytes.push_back(to_byte(value));
    bytes.push_back(255);
  }
  return bytes;
}

// A picture with blocks of one colour, single pixels, repeated rows, and invalid values.
std::vector<float> picture(int width, int height) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> stops(-14.0f, 8.0f);
  std::vector<float> rgba(4 * size_t(width) * size_t(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float* pixel = &rgba[4 * size_t(y * width + x)];
      const float* left = pixel - 4;
      const float* above = pixel - 4 * width;
      if (y % 3 == 1) {
        std::copy_n(above, 4, pixel);
      } else if (x % 5 > 1) {
        std::copy_n(left, 4, pixel);
      } else {
        for (int c = 0; c < 4; ++c) pixel[c] = std::exp2(stops(random));
      }
    }
  }
  rgba[0] = std::numeric_limits<float>::quiet_NaN();
  rgba[5] = std::numeric_limits<float>::infinity();
  rgba[10] = -3.0f;
  rgba[12] = 0.0f;
  rgba[13] = 1e-42f;
  rgba[14] = 1.0f;
  return rgba;
}

class GradingTest : public ::testing::TestWithParam<const char*> {};

TEST_P(GradingTest, GivesTheBytesOfTheFiles) {
  constexpr int kWidth = 61, kHeight = 37;
  const std::vector<float> rgba = picture(kWidth, kHeight);
  for (const float exposure : {0.0f, 1.5f, -6.25f}) {
    DisplaySettings settings;
    settings.view = GetParam();
    settings.exposure = exposure;
    const Grading grading(settings);
    std::vector<uint8_t> bytes(rgba.size());
    grading.grade(rgba, kWidth, bytes);
    EXPECT_EQ(bytes, expected(settings, rgba)) << exposure;
    // The result is the same by way of another exposure, as when a slider moves.
    DisplaySettings other = settings;
    other.exposure = 3.0f;
    std::vector<uint8_t> slid(rgba.size());
    Grading(Grading(other), exposure).grade(rgba, kWidth, slid);
    EXPECT_EQ(slid, bytes) << exposure;
    std::vector<float> shown = rgba;
    grading.to_display(shown);
    for (size_t i = 0; i < rgba.size(); ++i) {
      if (i % 4 < 3) {
        ASSERT_EQ(to_byte(shown[i]), bytes[i]) << i;
      } else {
        ASSERT_EQ(shown[i], rgba[i]) << i;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Views, GradingTest, ::testing::Values("sRGB", "ACES", "Raw"));

// Tests positive floats over the whole range, in relative steps below 2^-7.
TEST(Grading, AgreesAlongTheWholeScale) {
  std::vector<float> rgba;
  for (uint32_t bits = 0; bits < 0x7f800000u; bits += 0x8001) {
    const float value = std::bit_cast<float>(bits);
    for (int c = 0; c < 4; ++c) rgba.push_back(value);
  }
  const DisplaySettings settings;
  std::vector<uint8_t> bytes(rgba.size());
  Grading(settings).grade(rgba, int(rgba.size() / 4), bytes);
  EXPECT_EQ(bytes, expected(settings, rgba));
}

TEST(Grading, RejectsInvalidTransforms) {
  DisplaySettings settings;
  settings.view = "Film noir";
  EXPECT_THROW(Grading{settings}, UsageError);
  settings = {};
  settings.exposure = std::numeric_limits<float>::infinity();
  EXPECT_THROW(Grading{settings}, UsageError);
  EXPECT_THROW(Grading(Grading({}), NAN), UsageError);
}

}  // namespace
}  // namespace emberline
