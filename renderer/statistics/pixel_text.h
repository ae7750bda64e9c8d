// Text drawn into a picture with a built-in bitmap font of our own, printable ASCII.
//
// A glyph is 5 pixels wide and 9 high, with the lowest two for descenders; letters advance by 6
// pixels. An integer `scale` multiplies everything, so text is as sharp at 4K as at 320x180.
#pragma once

#include <string_view>

#include "renderer/statistics/byte_picture.h"

namespace emberline {

inline constexpr int kGlyphWidth = 5, kGlyphHeight = 9, kGlyphAdvance = 6;

// Width of the line in pixels, without the gap after its last letter.
int text_width(std::string_view text, int scale);
inline int text_height(int scale) { return kGlyphHeight * scale; }

// Draws one line with its upper left corner at x, y, clipped to the picture. Characters other than
// printable ASCII appear as '?'.
void draw_text(BytePicture& picture, int x, int y, std::string_view text, int scale,
               const Rgb8& colour);

// Whether a glyph covers (x, y) of its 5 x 9 pixels.
bool glyph_ink(char character, int x, int y);

}  // namespace emberline
