// An in-memory picture of display colours, with functions for drawing.
#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/core/byte_image.h"
#include "renderer/core/rect.h"
#include "renderer/statistics/colour_map.h"

namespace emberline {

// A picture with three sRGB channels.
struct BytePicture : ByteImage {
  BytePicture() = default;
  BytePicture(int w, int h, const Rgb8& colour) {
    width = w;
    height = h;
    values.resize(3 * size_t(w) * size_t(h));
    fill(bounds(), colour);
  }

  Rect bounds() const { return {0, 0, width, height}; }
  uint8_t* at(int x, int y) { return &values[3 * bounds().index_of(x, y)]; }
  const uint8_t* at(int x, int y) const { return &values[3 * bounds().index_of(x, y)]; }
  Rgb8 colour(int x, int y) const {
    const uint8_t* p = at(x, y);
    return {p[0], p[1], p[2]};
  }
  // Fills the part of `rect` that is inside the picture.
  void fill(const Rect& rect, const Rgb8& colour) {
    const Rect part = rect.intersect(bounds());
    for (int y = part.y0; y < part.y1; ++y) {
      for (int x = part.x0; x < part.x1; ++x) {
        uint8_t* p = at(x, y);
        for (size_t c = 0; c < 3; ++c) p[c] = colour[c];
      }
    }
  }
};

}  // namespace emberline
