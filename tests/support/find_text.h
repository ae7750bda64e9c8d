// Finds text that was drawn into a picture.
#pragma once

#include <string_view>

#include "renderer/statistics/pixel_text.h"

namespace emberline::test {

// Whether the text is at (x, y): all ink has one colour, and the gaps do not have it.
inline bool text_at(const BytePicture& picture, int x, int y, std::string_view text, int scale) {
  bool first = true;
  Rgb8 ink{};
  for (const bool inked : {true, false}) {
    for (size_t i = 0; i < text.size(); ++i) {
      for (int row = 0; row < kGlyphHeight; ++row) {
        for (int column = 0; column < kGlyphWidth; ++column) {
          if (glyph_ink(text[i], column, row) != inked) continue;
          const int px = x + (int(i) * kGlyphAdvance + column) * scale, py = y + row * scale;
          for (const int d : {0, scale - 1}) {
            const Rgb8 colour = picture.colour(px + d, py + d);
            if (first) ink = colour;
            first = false;
            if ((colour == ink) != inked) return false;
          }
        }
      }
    }
  }
  return true;
}

inline bool shows_text(const BytePicture& picture, std::string_view text, int scale = 1) {
  for (int y = 0; y + text_height(scale) <= picture.height; ++y) {
    for (int x = 0; x + text_width(text, scale) <= picture.width; ++x) {
      if (text_at(picture, x, y, text, scale)) return true;
    }
  }
  return false;
}

}  // namespace emberline::test
