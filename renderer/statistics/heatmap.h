// Draws a picture that shows one number for each pixel of a frame: sample density (bright where
// there are many samples, as in figure 1 of Painter & Sloan 1989), error, time, or stop reason.
//
// The frame's pixels are in the upper left corner, at their original size; the legend is below them
// and covers none of them. The picture is only for viewing; the EXR has the numbers as channels.
// Pictures of equal planes with equal settings are identical in every byte.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "renderer/statistics/byte_picture.h"
#include "renderer/statistics/colour_map.h"
#include "renderer/statistics/heatmap_legend.h"
#include "renderer/statistics/plane.h"
#include "renderer/statistics/value_scale.h"

namespace emberline {

// One possible value of a plane whose values are categories, such as stop reasons, instead of
// amounts.
struct Category {
  float value = 0;
  std::string name;  // UTF-8, with characters that TextFont has
  Rgb8 colour;
};

// The appearance of a heatmap. Range and logarithmic scale do not apply to categories.
struct HeatmapStyle {
  ColourMap colours = ColourMap::kGrey;
  std::optional<ValueRange> range;  // of the colour scale; min < max, and min > 0 if `logarithmic`
  bool logarithmic = false;
  bool plain = false;  // no legend
  // Names of the channels that the setting `judge` lists, for the quantity `judge`.
  std::vector<std::string> judged = {};
};

struct HeatmapSettings : HeatmapStyle {
  std::string title;  // such as "samples per pixel"; only characters that TextFont has
  std::string unit;   // shown after the title; "s" becomes s, ms, µs or ns; may be empty
  double bright = kBrightQuantile;  // for automatic_range()
  bool rms = false;                 // the legend also shows the RMS
  std::string note = {};            // the last text of the legend
};

// The plane must not be empty (asserted).
BytePicture draw_heatmap(const Plane& plane, const HeatmapSettings& settings);

// Like draw_heatmap(), but for categories. For each category that occurs, the legend shows a
// swatch, the name and the percentage of pixels. A value that belongs to no category counts as
// missing. Uses only `title` and `plain` of the settings.
BytePicture draw_category_map(const Plane& plane, std::span<const Category> categories,
                              const HeatmapSettings& settings);

// Return the layout of the legend that draw_heatmap() or draw_category_map() draws if `plain` is
// not set.
LegendLayout heatmap_layout(const Plane& plane, const HeatmapSettings& settings);
LegendLayout category_layout(const Plane& plane, std::span<const Category> categories,
                             const HeatmapSettings& settings);

}  // namespace emberline
