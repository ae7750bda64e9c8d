// Draws text into a picture, in DejaVu Sans (font/), anti-aliased, in any size.
//
// Glyphs are not hinted, so FreeType's environment variables have no effect, and equal texts result
// in identical pixels.
#pragma once

#include <memory>
#include <string_view>

#include "renderer/core/rect.h"
#include "renderer/statistics/byte_picture.h"

namespace emberline {

// The font in one size. Use an object from only one thread at a time; different objects share
// nothing.
class TextFont {
 public:
  explicit TextFont(int size);  // pixels per em, at least 1; a capital letter is 0.73 em high
  ~TextFont();
  TextFont(const TextFont&) = delete;
  TextFont& operator=(const TextFont&) = delete;

  // ascent() and height() return the distances in pixels from the top of a line to its baseline and
  // to its lowest descender.
  int ascent() const;
  int height() const;
  // Returns the width of the line in pixels, rounded up. The text is UTF-8. A character that the
  // font lacks and an invalid byte count as '?'.
  int width(std::string_view text) const;
  // Draws one line with its upper left corner at (x, y), clipped to the picture.
  void draw(BytePicture& picture, int x, int y, std::string_view text, const Rgb8& colour) const;

  // Whether the font has the character.
  bool has(char32_t character) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace emberline
