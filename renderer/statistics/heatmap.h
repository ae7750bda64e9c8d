// Pictures of a number for each pixel of a frame: sample density (bright where there are many
// samples, as in figure 1 of Painter & Sloan 1989), error, time, stop reasons.
//
// Pixels map one to one from the upper left corner; the legend is below them and covers none. The
// picture is a view: the numbers are channels of the EXR. Equal planes and settings give equal
// bytes.
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

// A named value of a plane whose values are reasons instead of amounts.
struct Category {
  float value = 0;
  std::string name;  // UTF-8, with characters that TextFont has
  Rgb8 colour;
};

// The appearance of a heatmap. Range and logarithmic scale do not apply to categories.
struct HeatmapStyle {
  ColourMap colours = ColourMap::kGrey;
  std::optional<ValueRange> range;  // of the colours; min < max, with `logarithmic` min > 0
  bool logarithmic = false;
  bool plain = false;  // no legend
};

struct HeatmapSettings : HeatmapStyle {
  std::string title;  // what the values are, such as "samples per pixel"; as Category::name
  std::string unit;   // after the title; "s" is shown as s, ms, µs or ns; may be empty
  double bright = kBrightQuantile;  // for an automatic range
  bool rms = false;                 // the legend also shows the RMS
  std::string note = {};            // the last text of the legend
};

// The plane's sides must not be 0 (asserted).
BytePicture draw_heatmap(const Plane& plane, const HeatmapSettings& settings);

// The same for categories: a swatch, name and share of pixels for each one that occurs. Values of
// no category count as missing. Uses only the title and `plain` of the settings.
BytePicture draw_category_map(const Plane& plane, std::span<const Category> categories,
                              const HeatmapSettings& settings);

// The legends that they draw unless the settings are `plain`.
LegendLayout heatmap_layout(const Plane& plane, const HeatmapSettings& settings);
LegendLayout category_layout(const Plane& plane, std::span<const Category> categories,
                             const HeatmapSettings& settings);

}  // namespace emberline
