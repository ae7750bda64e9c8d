#include "renderer/window/picture/histogram.h"

#include <gtest/gtest.h>

namespace emberline {
namespace {

std::shared_ptr<const SessionPicture> picture_of(
    const std::vector<std::array<uint8_t, 3>>& pixels) {
  auto picture = std::make_shared<SessionPicture>();
  picture->width = int(pixels.size());
  picture->height = 1;
  for (const auto& p : pixels) picture->rgba8.insert(picture->rgba8.end(), {p[0], p[1], p[2], 255});
  return picture;
}

TEST(Histogram, CountsEachChannelBlackAndClipped) {
  Histogram histogram;
  histogram.update(picture_of({{0, 0, 0}, {100, 50, 50}, {100, 50, 255}, {0, 0, 1}}), 0.0);
  EXPECT_DOUBLE_EQ(histogram.black(), 0.25);
  EXPECT_DOUBLE_EQ(histogram.clipped(), 0.25);
  EXPECT_EQ(histogram.height(0, 50), 1.0f);  // two of 100, the maximum between black and white
  EXPECT_EQ(histogram.height(1, 25), 1.0f);
  EXPECT_EQ(histogram.height(2, 25), 0.5f);
  EXPECT_EQ(histogram.height(0, 51), 0.0f);
}

TEST(Histogram, ABlackGroundDoesNotFlattenTheRest) {
  std::vector<std::array<uint8_t, 3>> pixels(1000, {0, 0, 0});
  pixels.push_back({128, 128, 128});
  Histogram histogram;
  histogram.update(picture_of(pixels), 0.0);
  EXPECT_EQ(histogram.height(0, 64), 1.0f);
  EXPECT_EQ(histogram.height(0, 0), 1.0f);
}

TEST(Histogram, CountsOnlyNowAndThen) {
  Histogram histogram;
  histogram.update(picture_of({{0, 0, 0}}), 10.0);
  histogram.update(picture_of({{9, 9, 9}}), 10.05);
  EXPECT_EQ(histogram.black(), 1.0);
  histogram.update(picture_of({{9, 9, 9}}), 10.5);
  EXPECT_EQ(histogram.black(), 0.0);
}

}  // namespace
}  // namespace emberline
