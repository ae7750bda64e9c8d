// The legend below a heatmap, in two steps: lay_out_legend() computes the position of each text,
// swatch and tick, and draw_legend() draws them. Tests check the layout without reading pixels.
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

// A text in the legend. If the text explains a colour, a swatch of this colour precedes it.
struct LegendItem {
  std::string text;
  std::optional<Rgb8> swatch = std::nullopt;
};

// A colour bar, with a scale below it and a histogram of the plane's values above it.
struct LegendBar {
  const Plane& plane;
  ValueScale scale;
  ColourMap colours;
  double factor = 1;  // labels show value x factor
};

// The layout of a legend. Coordinates are those of the whole picture, which has the frame in its
// upper left corner.
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
  std::vector<Text> texts;  // one for each item; a long item is broken into several texts
  std::vector<Swatch> swatches;
  Rect histogram, bar;            // empty without a bar
  std::vector<Rect> ticks;        // below the bar
  std::vector<Text> tick_labels;  // fewer than ticks if labels would overlap
};

// Returns the layout for a frame of width x height pixels. The first item is the title; the others
// follow side by side, in lines. `bar` may be null. Letters grow with the frame, but are never too
// small to read, so the legend of a very small frame is wider than the frame.
LegendLayout lay_out_legend(int width, int height, std::span<const LegendItem> items,
                            const LegendBar* bar);

// Returns the whole picture with the legend. The frame's area is filled with the background colour.
// `bar` must be the one that was passed to lay_out_legend().
BytePicture draw_legend(const LegendLayout& layout, const LegendBar* bar);

}  // namespace emberline
