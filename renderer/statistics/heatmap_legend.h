// The legend below a heatmap.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "renderer/statistics/byte_picture.h"
#include "renderer/statistics/colour_map.h"
#include "renderer/statistics/plane.h"
#include "renderer/statistics/value_scale.h"

namespace emberline {

// A few words, behind a patch of colour if they are about one. Items stand side by side and go on
// in a new line where there is no more room.
struct LegendItem {
  std::string text;
  std::optional<Rgb8> swatch = std::nullopt;
};

// A colour bar with its scale below and a histogram of the plane's values above.
struct LegendBar {
  const Plane& plane;
  ValueScale scale;
  ColourMap colours;
  double factor = 1;  // labels show value x factor
};

// A picture with room for `width` x `height` pixels in its upper left corner and, below it, the
// items, the first of them the title, and the bar if there is one. Letters grow with the frame, to
// about the same share of it; the legend of a small frame is wider than the frame.
BytePicture frame_with_legend(int width, int height, const std::vector<LegendItem>& items,
                              const LegendBar* bar);

}  // namespace emberline
