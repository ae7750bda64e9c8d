// Heatmaps as pictures: the colour of each pixel, and the legend.
#include "renderer/statistics/heatmap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "renderer/statistics/heatmap_quantity.h"
#include "support/colour_vision.h"
#include "support/find_text.h"

namespace emberline::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Plane ramp(int width, int height) {
  Plane plane{width, height, {}};
  for (int i = 0; i < width * height; ++i) plane.values.push_back(float(i));
  return plane;
}

Plane constant(int width, int height, float value) {
  return {width, height, std::vector<float>(size_t(width) * size_t(height), value)};
}

HeatmapSettings titled(const char* title = "title") {
  HeatmapSettings settings;
  settings.title = title;
  return settings;
}

// Every pixel has the colour of its value, and nothing is drawn over it.
void expect_pixels(const Plane& plane, const HeatmapSettings& settings, const ValueRange& range) {
  const BytePicture picture = draw_heatmap(plane, settings);
  const ValueScale scale(range, settings.logarithmic);
  for (int y = 0; y < plane.height; ++y) {
    for (int x = 0; x < plane.width; ++x) {
      ASSERT_EQ(picture.colour(x, y),
                colour_of(settings.colours, scale.position(double(plane.at(x, y)))))
          << x << "," << y;
    }
  }
}

TEST(Heatmap, PixelsKeepTheirPlaceAtAnySize) {
  const std::pair<int, int> sizes[] = {{1, 1}, {16, 16}, {1, 300}, {300, 1}, {640, 360}, {37, 211}};
  for (const auto& [width, height] : sizes) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    const Plane plane = ramp(width, height);
    for (const bool plain : {false, true}) {
      HeatmapSettings settings = titled();
      settings.plain = plain;
      settings.range = ValueRange{0, 1000};
      expect_pixels(plane, settings, {0, 1000});
      const BytePicture picture = draw_heatmap(plane, settings);
      EXPECT_EQ(picture.values.size(), 3u * size_t(picture.width) * size_t(picture.height));
      if (plain) {
        EXPECT_EQ(picture.bounds(), (Rect{0, 0, width, height}));
      } else {
        EXPECT_GE(picture.width, std::max(width, 200));
        EXPECT_GT(picture.height, height + 60);
        EXPECT_TRUE(shows_text(picture, "title"));
      }
    }
  }
}

TEST(Heatmap, LettersGrowWithTheFrame) {
  for (const auto& [width, height, scale] :
       {std::tuple(320, 180, 1), std::tuple(1280, 720, 2), std::tuple(3840, 2160, 6)}) {
    const BytePicture picture = draw_heatmap(constant(width, height, 3), titled("density"));
    EXPECT_EQ(picture.width, width);
    // The first line of the legend, without the picture.
    BytePicture legend(width, 20 * scale, {0, 0, 0});
    std::copy_n(picture.at(0, height), legend.values.size(), legend.values.begin());
    EXPECT_TRUE(shows_text(legend, "density", scale)) << width;
    EXPECT_LT(picture.height - height, scale == 1 ? height / 2 : height / 4);
  }
}

TEST(Heatmap, SaysLeastMeanAndMostOfTheTrueValues) {
  HeatmapSettings settings = titled("samples per pixel");
  settings.range = ValueRange{2, 5};
  const BytePicture picture = draw_heatmap(ramp(320, 2), settings);  // 0 to 639
  for (const char* text : {"samples per pixel", "minimum 0", "mean 319.5", "maximum 639",
                           "0.3 % below the scale", "99.1 % above the scale"}) {
    EXPECT_TRUE(shows_text(picture, text)) << text;
  }
  EXPECT_FALSE(shows_text(picture, "uniform"));
  EXPECT_FALSE(shows_text(picture, "no value"));
  EXPECT_FALSE(shows_text(picture, "RMS"));
  settings.rms = true;
  EXPECT_TRUE(shows_text(draw_heatmap(ramp(320, 2), settings), "RMS 369.1"));
}

TEST(Heatmap, TheScaleHasItsNumbers) {
  HeatmapSettings settings = titled();
  settings.range = ValueRange{0, 100};
  const BytePicture picture = draw_heatmap(ramp(640, 2), settings);
  for (const char* text : {"0", "20", "40", "60", "80", "100"}) {
    EXPECT_TRUE(shows_text(picture, text)) << text;
  }
  // Below the bar's end; the bar has every colour in order.
  const int middle = picture.height - 25;
  for (int x = 10; x < 620; ++x) {
    ASSERT_LE(picture.colour(x, middle)[0], picture.colour(x + 1, middle)[0]);
  }
  EXPECT_LT(picture.colour(7, middle)[0], 4);
  EXPECT_GT(picture.colour(632, middle)[0], 251);
}

TEST(Heatmap, AConstantLooksUniformAndSaysSo) {
  for (const float value : {0.0f, 64.0f, 1e-6f}) {
    const BytePicture picture = draw_heatmap(constant(64, 36, value), titled());
    for (int i = 0; i < 64 * 36; ++i) {
      ASSERT_EQ(picture.colour(i % 64, i / 64), picture.colour(0, 0));
    }
    EXPECT_EQ(int(picture.colour(0, 0)[0]), value == 0.0f ? 0 : 128);
    EXPECT_TRUE(shows_text(picture, "uniform: every pixel has " + number_text(double(value))));
    EXPECT_FALSE(shows_text(picture, "mean"));
  }
}

TEST(Heatmap, PixelsWithoutValueStandOutAndAreCounted) {
  Plane plane = ramp(32, 2);
  plane.values[5] = kNan;
  plane.values[40] = std::numeric_limits<float>::infinity();
  for (const ColourMapEntry& entry : colour_map_table()) {
    HeatmapSettings settings = titled();
    settings.colours = entry.map;
    const BytePicture picture = draw_heatmap(plane, settings);
    EXPECT_EQ(picture.colour(5, 0), entry.no_value);
    EXPECT_EQ(picture.colour(8, 1), entry.no_value);
    EXPECT_TRUE(shows_text(picture, "no value: 2 pixels")) << entry.name;
    EXPECT_TRUE(shows_text(picture, "maximum 63"));
  }
  const BytePicture none = draw_heatmap(constant(8, 8, kNan), titled());
  EXPECT_TRUE(shows_text(none, "no value: 64 pixels"));
  EXPECT_FALSE(shows_text(none, "mean"));
}

TEST(Heatmap, ZerosOnALogarithmicScaleAreBelowIt) {
  Plane plane = constant(100, 1, 10.0f);
  plane.values[0] = 0.0f;
  plane.values[1] = 1.0f;
  plane.values[2] = 100.0f;
  HeatmapSettings settings = titled();
  settings.logarithmic = true;
  settings.range = ValueRange{1, 100};
  expect_pixels(plane, settings, {1, 100});
  const BytePicture picture = draw_heatmap(plane, settings);
  EXPECT_EQ(picture.colour(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_EQ(picture.colour(3, 0), (Rgb8{128, 128, 128}));
  EXPECT_EQ(picture.colour(2, 0), (Rgb8{255, 255, 255}));
  EXPECT_TRUE(shows_text(picture, "title, logarithmic"));
  EXPECT_TRUE(shows_text(picture, "1.0 % below the scale"));
}

TEST(Heatmap, AFewPixelsThatAreNotZeroAreNamed) {
  Plane plane = constant(200, 200, 0.0f);
  plane.values[12345] = 2;
  const BytePicture picture = draw_heatmap(plane, titled());
  EXPECT_TRUE(shows_text(picture, "not 0 in 1 pixel"));
  EXPECT_EQ(picture.colour(12345 % 200, 12345 / 200), (Rgb8{255, 255, 255}));
}

TEST(Heatmap, SecondsHaveAReadableUnit) {
  HeatmapSettings settings = titled("time per pixel");
  settings.unit = "s";
  Plane plane = ramp(300, 1);
  for (float& value : plane.values) value *= 1e-5f;
  const BytePicture picture = draw_heatmap(plane, settings);
  EXPECT_TRUE(shows_text(picture, "time per pixel (ms)"));
  EXPECT_TRUE(shows_text(picture, "maximum 2.99"));
}

// Columns of the histogram above the bar: 300 pixels of 1, 100 of 3, none of 2.
TEST(Heatmap, TheHistogramCountsPixels) {
  Plane plane = constant(400, 1, 1.0f);
  std::fill_n(plane.values.begin(), 100, 3.0f);
  HeatmapSettings settings = titled();
  settings.range = ValueRange{0, 4};
  const BytePicture picture = draw_heatmap(plane, settings);
  const Rgb8 ink = {150, 150, 150};
  const auto height_at = [&](double place) {
    const int x = 6 + int(place * (400 - 12));
    int height = 0;
    for (int y = 1; y < picture.height; ++y) height += picture.colour(x, y) == ink;
    return height;
  };
  EXPECT_EQ(height_at(0.25), 26);
  EXPECT_EQ(height_at(0.5), 0);
  EXPECT_EQ(height_at(0.75), 9);
}

TEST(CategoryMap, SwatchesNamesAndShares) {
  Plane plane = constant(100, 10, 1.0f);
  std::fill_n(plane.values.begin(), 250, 2.0f);
  plane.values[999] = 9;
  const Category categories[] = {
      {1, "one", {0, 114, 178}}, {2, "two", {240, 228, 66}}, {3, "three", {1, 2, 3}}};
  const BytePicture picture = draw_category_map(plane, categories, titled("reasons"));
  EXPECT_EQ(picture.colour(0, 0), categories[1].colour);
  EXPECT_EQ(picture.colour(50, 5), categories[0].colour);
  for (const char* text : {"reasons", "one: 74.9 %", "two: 25.0 %", "no value: 0.1 %"}) {
    EXPECT_TRUE(shows_text(picture, text)) << text;
  }
  EXPECT_FALSE(shows_text(picture, "three"));
  const auto below = [&](const Rgb8& colour) {
    int count = 0;
    for (int y = 11; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) count += picture.colour(x, y) == colour;
    }
    return count;
  };
  EXPECT_EQ(below(categories[0].colour), 49) << "a swatch of 9 x 9 with a border";
  EXPECT_EQ(below(categories[1].colour), 49);
}

TEST(CategoryMap, SharesNeverRoundToNoneOrAll) {
  Plane plane = constant(1000, 100, 1.0f);
  plane.values[0] = 2;
  const Category categories[] = {{1, "one", {0, 0, 0}}, {2, "two", {255, 255, 255}}};
  const BytePicture picture = draw_category_map(plane, categories, titled());
  EXPECT_TRUE(shows_text(picture, "one: > 99.9 %"));
  EXPECT_TRUE(shows_text(picture, "two: < 0.1 %"));
  plane.values[0] = 1;
  EXPECT_TRUE(shows_text(draw_category_map(plane, categories, titled()), "one: 100 %"));
}

// Distinguishable by lightness alone (grey print), and by colour for any colour vision.
TEST(CategoryMap, ReasonsAreDistinguishable) {
  const std::span<const Category> all = stop_categories();
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].value, float(i));
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GT(std::abs(lightness(all[i].colour) - lightness(all[j].colour)), 6.0)
          << all[i].name << " and " << all[j].name;
      EXPECT_GT(least_difference(all[i].colour, all[j].colour), 15.0)
          << all[i].name << " and " << all[j].name;
    }
  }
}

TEST(Heatmap, TheSameBytesEveryTime) {
  const Plane plane = ramp(123, 45);
  EXPECT_EQ(draw_heatmap(plane, titled()).values, draw_heatmap(plane, titled()).values);
}

}  // namespace
}  // namespace emberline::test
