// What heatmaps can show: from channels of the film to one number per pixel, and how it is drawn.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/statistics/heatmap.h"

namespace emberline {

struct HeatmapQuantity {
  std::string_view name;     // "samples"; also the name of the channel in a file of raw values
  std::string_view summary;  // for --help
  std::string_view title;    // in the picture
  std::string_view unit;
  std::optional<Aov> aov;                  // that must be rendered for it
  std::vector<std::string_view> channels;  // that it is computed from
  float (*value)(const float* channels);   // of a pixel, in that order; NaN: none
  bool reasons = false;                    // categories instead of amounts
  bool rms = false;
};
// The table behind --heatmap-of, its --help and its error message.
std::span<const HeatmapQuantity> heatmap_quantity_table();
const HeatmapQuantity& find_heatmap_quantity(std::string_view name);  // throws UsageError

// How a heatmap is to look.
struct HeatmapStyle {
  ColourMap colours = ColourMap::kGrey;
  std::optional<ValueRange> range;
  bool logarithmic = false;
  bool plain = false;
};
BytePicture draw_quantity(const HeatmapQuantity& quantity, const Plane& plane,
                          const HeatmapStyle& style);

}  // namespace emberline
