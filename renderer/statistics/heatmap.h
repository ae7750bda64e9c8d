// A number for each pixel of a frame, as a picture to look at: sample density (bright where many
// are, as in figure 1 of Painter & Sloan 1989), error, time, reasons.
//
// The picture keeps every pixel of the plane at its place, one to one, from the upper left corner;
// the legend is below it and covers nothing. It is a view: the numbers are channels of the EXR.
// Equal planes and settings give equal bytes.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "renderer/statistics/byte_picture.h"
#include "renderer/statistics/colour_map.h"
#include "renderer/statistics/plane.h"
#include "renderer/statistics/value_scale.h"

namespace emberline {

// What a value stands for where values are no amounts but reasons.
struct Category {
  float value = 0;
  std::string name;  // printable ASCII
  Rgb8 colour;
};

// How a heatmap is to look. A range and a logarithmic scale mean nothing to categories.
struct HeatmapStyle {
  ColourMap colours = ColourMap::kGrey;
  std::optional<ValueRange> range;  // of the colours; least < most, with `logarithmic` least > 0
  bool logarithmic = false;
  bool plain = false;  // no legend
};

struct HeatmapSettings : HeatmapStyle {
  std::string title;  // what the values are, "samples per pixel"; printable ASCII
  std::string unit;   // behind the title; "s" is told in s, ms, us or ns; may be empty
  double bright = kBrightQuantile;  // of an automatic range
  bool rms = false;                 // the legend names the root of the mean square too
};

// Neither side of the plane may be 0 (asserted).
BytePicture draw_heatmap(const Plane& plane, const HeatmapSettings& settings);

// The same of reasons: a swatch, name and share of the pixels for each category that occurs. Values
// that are no category's are no value. Of the settings, title and plain count.
BytePicture draw_category_map(const Plane& plane, std::span<const Category> categories,
                              const HeatmapSettings& settings);

}  // namespace emberline
