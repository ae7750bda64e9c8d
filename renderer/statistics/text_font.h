// Text drawn into a picture: DejaVu Sans (font/), anti-aliased, in any size.
//
// Glyphs are not hinted, so FreeType's settings in the environment have no effect: equal texts give
// equal bytes.
#pragma once

#include <memory>
#include <string_view>

#include "renderer/core/rect.h"
#include "renderer/statistics/byte_picture.h"

namespace emberline {

// The face in one size. Use an object from one thread at a time; different objects share nothing.
class TextFont {
 public:
  explicit TextFont(int size);  // pixels per em, at least 1; a capital letter is 0.73 em high
  ~TextFont();
  TextFont(const TextFont&) = delete;
  TextFont& operator=(const TextFont&) = delete;

  // From the top of a line to its baseline, and to its lowest descender, in pixels.
  int ascent() const;
  int height() const;
  // Width of the line in pixels, rounded up. Text is UTF-8; a character that the face lacks counts
  // as '?', and so does each invalid byte.
  int width(std::string_view text) const;
  // Draws one line with its upper left corner at x, y, clipped to the picture.
  void draw(BytePicture& picture, int x, int y, std::string_view text, const Rgb8& colour) const;

  // Whether the face has the character.
  bool has(char32_t character) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace emberline
