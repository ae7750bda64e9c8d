// A number for each pixel of a frame, as a picture to look at: sample density (bright where many
// are, as in figure 1 of Painter & Sloan 1989), error, time, reasons.
//
// The picture keeps every pixel of the plane at its place, one to one, from the upper left corner;
// the legend is below it and covers nothing. It is a view: the numbers are channels of the EXR.
// Equal planes and settings give equal bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/statistics/byte_picture.h"
#include "renderer/statistics/colour_map.h"

namespace emberline {

// One number per pixel, rows from the top. What is not finite is no value: it has a colour of its
// own and is left out of everything but the count of such pixels.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;
};

struct ValueRange {
  double least = 0, most = 1;
};

// What a value stands for where values are no amounts but reasons.
struct Category {
  float value = 0;
  std::string name;  // printable ASCII
  Rgb8 colour;
};

struct HeatmapSettings {
  std::string title;  // what the values are, "samples per pixel"; printable ASCII
  std::string unit;   // behind the title; "s" is told in s, ms, us or ns; may be empty
  ColourMap colours = ColourMap::kGrey;
  std::optional<ValueRange> range;  // of the colours; least < most, with `logarithmic` least > 0
  bool logarithmic = false;
  bool rms = false;    // the legend names the root of the mean square too
  bool plain = false;  // no legend
};

// The values in numbers, beyond the range of the colours too.
struct PlaneStatistics {
  uint64_t values = 0;    // pixels that have one
  uint64_t no_value = 0;  // and those that have none
  uint64_t not_zero = 0;
  double minimum = 0, mean = 0, maximum = 0, rms = 0;  // 0 if there is no value
  bool constant() const { return values > 0 && minimum == maximum; }
};
PlaneStatistics plane_statistics(const Plane& plane);

// The range that the colours span if none is given. Linear: from 0 (or the least value, if that is
// negative) to the 99.5 % quantile of the values that are not 0, so that a few outliers do not
// leave the rest black. Logarithmic: from the least value above 0 to the greatest. A constant plane
// is in the middle.
ValueRange automatic_range(const Plane& plane, bool logarithmic);

// Neither side of the plane may be 0 (asserted).
BytePicture draw_heatmap(const Plane& plane, const HeatmapSettings& settings);

// The same of reasons: a swatch, name and share of the pixels for each category that occurs. Values
// that are no category's are no value. Of the settings, title and plain count.
BytePicture draw_category_map(const Plane& plane, std::span<const Category> categories,
                              const HeatmapSettings& settings);

}  // namespace emberline
