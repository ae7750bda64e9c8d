// The legend below a heatmap, in two steps: where each text, swatch and tick goes, and drawing
// that. Tests check the first without reading pixels.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/statistics/byte_picture.h"
#include "renderer/statistics/colour_map.h"
#include "renderer/statistics/plane.h"
#include "renderer/statistics/value_scale.h"

namespace emberline {

// Text, after a colour swatch if it is about a colour.
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

// Places in the whole picture. The frame is its upper left corner.
struct LegendLayout {
  struct Text {
    std::string text;
    Rect box;  // from the top of a line to its lowest descender
    Rgb8 colour;
  };
  struct Swatch {
    Rect box;
    Rgb8 colour;
  };
  int letter = 0;  // pixels per em
  int line = 1;    // thickness of borders and ticks
  Rect picture, frame;
  std::vector<Text> texts;  // the items, of which long ones have several lines
  std::vector<Swatch> swatches;
  Rect histogram, bar;            // empty without a bar
  std::vector<Rect> ticks;        // below the bar
  std::vector<Text> tick_labels;  // fewer than ticks where labels would overlap
};

// Letters grow with the frame in proportion, down to a size that can still be read; a very small
// frame's legend is wider than the frame. Items stand side by side in lines; the first is the
// title. `bar` may be null.
LegendLayout lay_out_legend(int width, int height, std::span<const LegendItem> items,
                            const LegendBar* bar);

// A picture with the legend drawn and the frame left in the colour of the background. `bar` is the
// one of the layout.
BytePicture draw_legend(const LegendLayout& layout, const LegendBar* bar);

}  // namespace emberline
