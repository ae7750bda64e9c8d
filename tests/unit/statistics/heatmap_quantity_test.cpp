// Tests the quantities of heatmaps, which turn channels into a number per pixel.
#include "renderer/statistics/heatmap_quantity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/display_error.h"
#include "renderer/core/errors.h"
#include "renderer/drivers/adaptive/frame_error.h"
#include "unit/synthetic_pixels.h"

namespace emberline::test {
namespace {

TEST(HeatmapQuantity, EachUsesChannelsOfItsAov) {
  for (const HeatmapQuantity& quantity : heatmap_quantity_table()) {
    EXPECT_EQ(&find_heatmap_quantity(quantity.name), &quantity);
    AovSet aovs;
    if (quantity.aov) aovs.insert(*quantity.aov);
    EXPECT_EQ(QuantityPlane::missing_channel(quantity, film_channel_names(aovs)).empty(),
              !quantity.needs_denoised)
        << quantity.name;
    if (quantity.aov) {
      EXPECT_NE(QuantityPlane::missing_channel(quantity, film_channel_names({})), "");
    }
  }
  EXPECT_THROW(find_heatmap_quantity("noise"), UsageError);
}

TEST(HeatmapQuantity, ErrorIsDeviationTimesTheCurvesSlope) {
  const HeatmapQuantity& error = find_heatmap_quantity("error");
  // The pixel is a grey of .3, known to +- .01 in each channel. The slope is measured over the same
  // width.
  const float grey[] = {64, .3f, .3f, .3f, 1e-4f, 1e-4f, 1e-4f};
  const double slope = double(display_value(0.31f) - display_value(0.29f)) / 0.02;
  EXPECT_NEAR(double(error.value(grey)), 0.01 * slope, 1e-5);
  // The error of one channel is pooled with those of the other two, which are zero.
  const float red[] = {64, .3f, .3f, .3f, 1e-4f, 0, 0};
  EXPECT_NEAR(double(error.value(red)), 0.01 * slope / std::sqrt(3.0), 1e-5);
  // Noise on a lamp is hardly visible. The same noise in the dark is very visible.
  const float lamp[] = {64, 50, 50, 50, 1e-4f, 1e-4f, 1e-4f};
  const float dark[] = {64, .002f, .002f, .002f, 1e-4f, 1e-4f, 1e-4f};
  EXPECT_LT(error.value(lamp), 0.001f);
  EXPECT_GT(error.value(dark), error.value(grey));
  const float still[] = {64, .3f, .3f, .3f, 0, 0, 0};
  EXPECT_EQ(error.value(still), 0.0f);
}

TEST(HeatmapQuantity, ErrorOfFewerThanTwoSamplesIsUnknown) {
  const HeatmapQuantity& error = find_heatmap_quantity("error");
  for (const float samples : {0.0f, 1.0f}) {
    const float channels[] = {samples, .3f, .3f, .3f, 0, 0, 0};
    EXPECT_TRUE(std::isnan(error.value(channels)));
  }
}

// The RMS of the map equals the adaptive driver's estimate for the frame, in the middle of the
// curve, in the dark, and in clipped white.
TEST(HeatmapQuantity, RmsOfTheErrorIsTheFramesEstimate) {
  const HeatmapQuantity& error = find_heatmap_quantity("error");
  for (const double level : {0.3, 0.001, 5.0}) {
    const PixelStatistics pixels = drawn_pixels(64, 48, 32, 7, [level](TestRandom& random) {
      return level * (1 + 0.3 * draw_normal(random));
    });
    double sum = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
      const float n = pixels.count[i], b = pixels.second_count[i], a = n - b;
      float channels[7] = {n};
      for (size_t c = 0; c < 3; ++c) {
        const float difference = pixels.stream_difference[c][i];
        channels[1 + c] = pixels.mean[c][i];
        channels[4 + c] = difference * difference * a * b / (n * n);
      }
      sum += square(double(error.value(channels)));
    }
    const double estimate = frame_error(pixels);
    EXPECT_NEAR(std::sqrt(sum / double(pixels.size())), estimate, 1e-5 * estimate) << level;
  }
}

TEST(QuantityPlane, GathersTilesInAnyOrder) {
  const Rect crop{10, 20, 15, 24};
  const std::vector<std::string> channels = {"R", "samples"};
  QuantityPlane gathered(find_heatmap_quantity("samples"), channels, crop);
  for (const Rect& tile : {Rect{12, 20, 15, 22}, Rect{10, 22, 15, 24}, Rect{10, 20, 12, 22}}) {
    std::vector<float> pixels;
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) {
        pixels.insert(pixels.end(), {-1.0f, float(100 * y + x)});
      }
    }
    gathered.write_tile(tile, pixels);
  }
  const Plane& plane = gathered.plane();
  EXPECT_EQ(plane.width, 5);
  EXPECT_EQ(plane.height, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) EXPECT_EQ(plane.at(x, y), float(100 * (y + 20) + x + 10));
  }
}

TEST(QuantityPlane, PixelsThatNeverComeHaveNoSamples) {
  std::vector<std::string> all =
      film_channel_names(AovSet::parse("variance,time,stop,non_finite,part,rays"));
  all.push_back("denoised.error");
  for (const HeatmapQuantity& quantity : heatmap_quantity_table()) {
    const QuantityPlane plane(quantity, all, {0, 0, 2, 2});
    const float value = plane.plane().values[3];
    if (quantity.name == "error") {
      EXPECT_TRUE(std::isnan(value));
    } else {
      EXPECT_EQ(value, 0.0f) << quantity.name;
    }
  }
}

}  // namespace
}  // namespace emberline::test
