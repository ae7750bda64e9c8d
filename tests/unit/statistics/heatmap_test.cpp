// Tests heatmaps as pictures: the colour of each pixel, and the legend.
#include "renderer/statistics/heatmap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "renderer/statistics/heatmap_quantity.h"
#include "renderer/statistics/text_font.h"
#include "support/colour_vision.h"

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

// Returns the legend's texts, in order, as one line.
std::string text_of(const LegendLayout& layout) {
  std::string all = " ";
  for (const auto* texts : {&layout.texts, &layout.tick_labels}) {
    for (const LegendLayout::Text& text : *texts) all += text.text + " ";
  }
  return all;
}

bool says(const LegendLayout& layout, const std::string& words) {
  return text_of(layout).find(" " + words + " ") != std::string::npos;
}

bool apart(const Rect& a, const Rect& b) {
  const Rect both = a.intersect(b);
  return both.width() <= 0 || both.height() <= 0;
}

// Expects that all parts are inside the legend and do not overlap, and that texts fit their boxes.
void expect_tidy(const LegendLayout& layout) {
  EXPECT_EQ(layout.frame.x0, 0);
  EXPECT_EQ(layout.frame.y0, 0);
  std::vector<Rect> parts;
  for (const auto* texts : {&layout.texts, &layout.tick_labels}) {
    for (const LegendLayout::Text& text : *texts) {
      parts.push_back(text.box);
      EXPECT_EQ(text.box.width(), TextFont(layout.letter).width(text.text)) << text.text;
      EXPECT_EQ(text.box.height(), TextFont(layout.letter).height());
    }
  }
  for (const LegendLayout::Swatch& swatch : layout.swatches) parts.push_back(swatch.box);
  for (const Rect& tick : layout.ticks) parts.push_back(tick);
  if (layout.bar.area() > 0) {
    parts.push_back(layout.bar);
    parts.push_back(layout.histogram);
  }
  for (size_t i = 0; i < parts.size(); ++i) {
    EXPECT_GE(parts[i].x0, 1);
    EXPECT_GT(parts[i].y0, layout.frame.y1);
    EXPECT_LT(parts[i].x1, layout.picture.x1);
    EXPECT_LT(parts[i].y1, layout.picture.y1);
    for (size_t j = 0; j < i; ++j) EXPECT_TRUE(apart(parts[i], parts[j])) << i << " and " << j;
  }
}

// Expects every pixel to have the colour of its value, with nothing drawn over it.
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
        const LegendLayout layout = heatmap_layout(plane, settings);
        EXPECT_EQ(layout.picture, picture.bounds());
        EXPECT_TRUE(says(layout, "title"));
        expect_tidy(layout);
      }
    }
  }
}

TEST(Heatmap, LettersGrowWithTheFrame) {
  for (const auto& [width, height, letter] :
       {std::tuple(320, 180, 11), std::tuple(1280, 720, 18), std::tuple(3840, 2160, 54)}) {
    const Plane plane = constant(width, height, 3);
    const LegendLayout layout = heatmap_layout(plane, titled("density"));
    EXPECT_EQ(layout.letter, letter);
    EXPECT_EQ(layout.picture.width(), width);
    EXPECT_EQ(layout.picture, draw_heatmap(plane, titled("density")).bounds());
    EXPECT_LT(layout.picture.height() - height, width == 320 ? height / 2 : height / 4);
    expect_tidy(layout);
  }
}

// Tests every quantity with all the texts that it can have, on frames of many sizes.
TEST(Heatmap, LegendsOfAllQuantitiesAreTidy) {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(64, 36), std::pair(320, 180), std::pair(640, 360),
        std::pair(1280, 720), std::pair(1080, 1920), std::pair(3840, 2160)}) {
    Plane plane{width, height, {}};
    for (int i = 0; i < width * height; ++i) plane.values.push_back(float(i % 1000) * 3e-4f);
    plane.values.back() = kNan;
    for (const HeatmapQuantity& quantity : heatmap_quantity_table()) {
      SCOPED_TRACE(std::string(quantity.name) + " " + std::to_string(width));
      HeatmapSettings settings = titled(std::string(quantity.title).c_str());
      settings.unit = quantity.unit;
      settings.rms = true;
      for (const bool logarithmic : {false, true}) {
        settings.logarithmic = logarithmic;
        settings.range = ValueRange{1e-3, 0.2};
        const LegendLayout layout = heatmap_layout(plane, settings);
        expect_tidy(layout);
        EXPECT_TRUE(says(layout, std::string(quantity.title)) || !quantity.unit.empty() ||
                    logarithmic);
        if (width >= 320) {
          EXPECT_EQ(layout.picture.width(), width);
        }
      }
    }
    for (int i = 0; i < width * height; ++i) plane.values[size_t(i)] = float(i % 9);
    const LegendLayout layout = category_layout(plane, stop_categories(), titled("reasons"));
    expect_tidy(layout);
    EXPECT_EQ(layout.swatches.size() + 1, layout.texts.size());
  }
}

TEST(Heatmap, ALongTitleIsBrokenBetweenWords) {
  const std::string title = "estimated error when denoised, RMS as displayed (0 to 1)";
  const LegendLayout layout = heatmap_layout(ramp(64, 36), titled(title.c_str()));
  EXPECT_TRUE(says(layout, title + " minimum 0"));
  ASSERT_GE(layout.texts.size(), 3u);
  EXPECT_EQ(layout.texts[0].colour, layout.texts[1].colour);
  EXPECT_EQ(layout.texts[2].text, "minimum 0");
  EXPECT_NE(layout.texts[2].colour, layout.texts[0].colour);
  EXPECT_GT(layout.texts[2].box.y0, layout.texts[1].box.y0) << "on a new line";
}

// Everything that is drawn below the frame is inside the boxes of the layout.
TEST(Heatmap, TheLegendIsDrawnAsLaidOut) {
  const Plane plane = ramp(400, 225);
  const LegendLayout layout = heatmap_layout(plane, titled("samples per pixel"));
  const BytePicture picture = draw_heatmap(plane, titled("samples per pixel"));
  const Rgb8 background = picture.colour(layout.picture.x1 - 1, layout.picture.y1 - 1);
  std::vector<Rect> parts = layout.ticks;
  parts.insert(parts.end(), {layout.bar, layout.histogram});
  for (const auto* texts : {&layout.texts, &layout.tick_labels}) {
    for (const LegendLayout::Text& text : *texts) {
      parts.push_back(text.box);
      int ink = 0;
      for (int y = text.box.y0; y < text.box.y1; ++y) {
        for (int x = text.box.x0; x < text.box.x1; ++x) ink += picture.colour(x, y) != background;
      }
      EXPECT_GT(ink, 0) << text.text;
    }
  }
  for (int y = layout.frame.y1 + layout.line; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture.colour(x, y) == background) continue;
      ASSERT_TRUE(std::ranges::any_of(parts,
                                      [&](const Rect& part) {
                                        return !apart(part, {x, y, x + 1, y + 1});
                                      }))
          << x << "," << y;
    }
  }
}

TEST(Heatmap, SaysLeastMeanAndMostOfTheTrueValues) {
  HeatmapSettings settings = titled("samples per pixel");
  settings.range = ValueRange{2, 5};
  const LegendLayout layout = heatmap_layout(ramp(320, 10), settings);  // 0 to 3199
  for (const char* text : {"samples per pixel", "minimum 0", "mean 1,600", "maximum 3,199",
                           "0.1 % below the scale", "99.8 % above the scale"}) {
    EXPECT_TRUE(says(layout, text)) << text;
  }
  for (const char* text : {"uniform", "no value", "RMS"}) {
    EXPECT_EQ(text_of(layout).find(text), std::string::npos) << text;
  }
  settings.rms = true;
  EXPECT_TRUE(says(heatmap_layout(ramp(320, 2), settings), "RMS 369.1"));
}

TEST(Heatmap, TheScaleHasItsNumbers) {
  HeatmapSettings settings = titled();
  settings.range = ValueRange{0, 1000};
  const Plane plane = ramp(640, 2);
  const LegendLayout layout = heatmap_layout(plane, settings);
  std::vector<std::string> labels;
  for (const LegendLayout::Text& label : layout.tick_labels) labels.push_back(label.text);
  EXPECT_EQ(labels, (std::vector<std::string>{"0", "100", "200", "300", "400", "500", "600", "700",
                                              "800", "900", "1,000"}));
  // Ticks are below the bar at the places of their values, and labels below the ticks.
  ASSERT_EQ(layout.ticks.size(), labels.size());
  for (size_t i = 0; i < labels.size(); ++i) {
    const Rect &tick = layout.ticks[i], &label = layout.tick_labels[i].box;
    EXPECT_NEAR(tick.x0, layout.bar.x0 + 0.1 * double(i) * (layout.bar.width() - layout.line),
                0.51);
    EXPECT_EQ(tick.y0, layout.bar.y1);
    EXPECT_GE(label.y0, tick.y1);
    if (i > 0 && i + 1 < labels.size()) {
      EXPECT_NEAR(label.x0 + label.x1, tick.x0 + tick.x1, 2);
    }
  }
  EXPECT_GE(layout.ticks.front().x0, layout.bar.x0);
  EXPECT_LE(layout.ticks.back().x1, layout.bar.x1);
  // The bar has every colour in order.
  const BytePicture picture = draw_heatmap(plane, settings);
  const int middle = (layout.bar.y0 + layout.bar.y1) / 2, end = layout.bar.x1 - 1;
  for (int x = layout.bar.x0; x < end; ++x) {
    ASSERT_LE(picture.colour(x, middle)[0], picture.colour(x + 1, middle)[0]);
  }
  EXPECT_LT(picture.colour(layout.bar.x0, middle)[0], 4);
  EXPECT_GT(picture.colour(end, middle)[0], 251);
}

TEST(Heatmap, AConstantLooksUniformAndSaysSo) {
  for (const float value : {0.0f, 64.0f, 1e-6f}) {
    const BytePicture picture = draw_heatmap(constant(64, 36, value), titled());
    for (int i = 0; i < 64 * 36; ++i) {
      ASSERT_EQ(picture.colour(i % 64, i / 64), picture.colour(0, 0));
    }
    EXPECT_EQ(int(picture.colour(0, 0)[0]), value == 0.0f ? 0 : 128);
    const LegendLayout layout = heatmap_layout(constant(64, 36, value), titled());
    EXPECT_TRUE(says(layout, "uniform: every pixel has " + number_text(double(value))));
    EXPECT_FALSE(says(layout, "mean"));
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
    const LegendLayout layout = heatmap_layout(plane, settings);
    EXPECT_TRUE(says(layout, "no value: 2 pixels")) << entry.name;
    EXPECT_TRUE(says(layout, "maximum 63"));
    ASSERT_EQ(layout.swatches.size(), 1u);
    EXPECT_EQ(layout.swatches[0].colour, entry.no_value);
  }
  const LegendLayout none = heatmap_layout(constant(80, 80, kNan), titled());
  EXPECT_TRUE(says(none, "no value: 6,400 pixels"));
  EXPECT_FALSE(says(none, "mean"));
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
  EXPECT_TRUE(says(heatmap_layout(plane, settings), "title, log scale"));
  EXPECT_TRUE(says(heatmap_layout(plane, settings), "1.0 % below the scale"));
}

TEST(Heatmap, AFewPixelsThatAreNotZeroAreNamed) {
  Plane plane = constant(200, 200, 0.0f);
  plane.values[12345] = 2;
  const BytePicture picture = draw_heatmap(plane, titled());
  EXPECT_TRUE(says(heatmap_layout(plane, titled()), "nonzero in 1 pixel"));
  EXPECT_EQ(picture.colour(12345 % 200, 12345 / 200), (Rgb8{255, 255, 255}));
}

TEST(Heatmap, SecondsHaveAReadableUnit) {
  HeatmapSettings settings = titled("time per pixel");
  settings.unit = "s";
  Plane plane = ramp(300, 1);
  for (float& value : plane.values) value *= 1e-5f;
  EXPECT_TRUE(says(heatmap_layout(plane, settings), "time per pixel (ms)"));
  EXPECT_TRUE(says(heatmap_layout(plane, settings), "maximum 2.99"));
  for (float& value : plane.values) value *= 1e-3f;
  EXPECT_TRUE(says(heatmap_layout(plane, settings), "time per pixel (µs)"));
}

// The histogram above the bar has columns for 300 pixels of 1, none of 2 and 100 of 3.
TEST(Heatmap, TheHistogramCountsPixels) {
  Plane plane = constant(400, 1, 1.0f);
  std::fill_n(plane.values.begin(), 100, 3.0f);
  HeatmapSettings settings = titled();
  settings.range = ValueRange{0, 4};
  const BytePicture picture = draw_heatmap(plane, settings);
  const Rect area = heatmap_layout(plane, settings).histogram;
  const Rgb8 ink = {150, 150, 150};
  const auto height_at = [&](double place) {
    const int x = area.x0 + int(place * area.width());
    int height = 0;
    for (int y = area.y0; y < area.y1; ++y) height += picture.colour(x, y) == ink;
    return height;
  };
  EXPECT_EQ(height_at(0.25), area.height());
  EXPECT_EQ(height_at(0.5), 0);
  EXPECT_NEAR(height_at(0.75), area.height() / 3.0, 1.0);
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
  const LegendLayout layout = category_layout(plane, categories, titled("reasons"));
  EXPECT_EQ(text_of(layout), " reasons one: 74.9 % two: 25.0 % no value: 0.1 % ");
  ASSERT_EQ(layout.swatches.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const LegendLayout::Swatch& swatch = layout.swatches[i];
    EXPECT_LT(swatch.box.x1, layout.texts[i + 1].box.x0) << "left of its text";
    const Rgb8 middle =
        picture.colour((swatch.box.x0 + swatch.box.x1) / 2, (swatch.box.y0 + swatch.box.y1) / 2);
    EXPECT_EQ(middle, swatch.colour);
    if (i < 2) {
      EXPECT_EQ(middle, categories[i].colour);
    }
  }
}

TEST(CategoryMap, SharesNeverRoundToNoneOrAll) {
  Plane plane = constant(1000, 100, 1.0f);
  plane.values[0] = 2;
  const Category categories[] = {{1, "one", {0, 0, 0}}, {2, "two", {255, 255, 255}}};
  const LegendLayout layout = category_layout(plane, categories, titled());
  EXPECT_TRUE(says(layout, "one: > 99.9 %"));
  EXPECT_TRUE(says(layout, "two: < 0.1 %"));
  plane.values[0] = 1;
  EXPECT_TRUE(says(category_layout(plane, categories, titled()), "one: 100 %"));
}

// Reasons are distinguishable by lightness alone (in a grey print), and by colour for any colour
// vision.
TEST(CategoryMap, ReasonsAreDistinguishable) {
  const std::span<const Category> all = stop_categories();
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].value, float(i));
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GT(std::abs(lightness(all[i].colour) - lightness(all[j].colour)), 6.0)
          << all[i].name << " and " << all[j].name;
      EXPECT_GT(min_difference(all[i].colour, all[j].colour), 15.0)
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
