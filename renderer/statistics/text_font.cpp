#include "renderer/statistics/text_font.h"

#include <ft2build.h>
// ft2build.h must come first, because it defines the macros below.
#include FT_FREETYPE_H
#include FT_ADVANCES_H
#include FT_OUTLINE_H

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>

#include "renderer/core/errors.h"
#include "renderer/core/utf8.h"

namespace emberline {
namespace {

constexpr unsigned char kFaceBytes[] = {
#include "dejavu_sans.inc"
};

// Height of the highest glyph above the baseline, and depth of the lowest glyph below it, in em.
constexpr double kAscent = 0.82, kDescent = 0.24;

void check(FT_Error error) {
  if (error == 0) return;
  if (error == FT_Err_Out_Of_Memory) throw std::bad_alloc();
  throw RenderError("labels: FreeType reports error {}", error);
}

// Removes the first character from `text` and returns it.
char32_t pop_character(std::string_view* text) {
  const size_t length = utf8_length(*text);
  const auto byte = [&](size_t i) { return char32_t(static_cast<unsigned char>((*text)[i])); };
  constexpr unsigned kLeadBits[] = {0x00, 0x7f, 0x1f, 0x0f, 0x07};
  char32_t character = length == 0 ? U'?' : byte(0) & kLeadBits[length];
  for (size_t i = 1; i < length; ++i) character = character << 6 | (byte(i) & 0x3f);
  text->remove_prefix(std::max<size_t>(length, 1));
  return character;
}

// Blends `colour` into a pixel. A coverage of 0 leaves the pixel unchanged; 255 replaces it.
void blend(BytePicture& picture, int x, int y, const Rgb8& colour, int coverage) {
  uint8_t* pixel = picture.at(x, y);
  for (size_t c = 0; c < 3; ++c) {
    pixel[c] = uint8_t((pixel[c] * (255 - coverage) + colour[c] * coverage + 127) / 255);
  }
}

void blend(BytePicture& picture, int x, int y, const FT_Bitmap& glyph, const Rgb8& colour) {
  const Rect area = Rect{x, y, x + int(glyph.width), y + int(glyph.rows)};
  const Rect part = area.intersect(picture.bounds());
  for (int py = part.y0; py < part.y1; ++py) {
    const unsigned char* row = glyph.buffer + std::ptrdiff_t(py - y) * glyph.pitch;
    for (int px = part.x0; px < part.x1; ++px) blend(picture, px, py, colour, row[px - x]);
  }
}

}  // namespace

struct TextFont::State {
  explicit State(int pixels) : size(pixels) {
    FT_Library opened = nullptr;
    check(FT_Init_FreeType(&opened));
    library.reset(opened);
    FT_Face loaded = nullptr;
    check(FT_New_Memory_Face(opened, kFaceBytes, FT_Long(sizeof(kFaceBytes)), 0, &loaded));
    face.reset(loaded);
    check(FT_Set_Pixel_Sizes(loaded, 0, FT_UInt(size)));
  }

  FT_UInt glyph_of(char32_t character) const {
    const FT_UInt found = FT_Get_Char_Index(face.get(), character);
    return found != 0 ? found : FT_Get_Char_Index(face.get(), U'?');
  }

  // Returns the advance of a glyph in pixels, in fixed point with 16 fractional bits.
  FT_Fixed advance_of(FT_UInt glyph) const {
    FT_Fixed advance = 0;
    check(FT_Get_Advance(face.get(), glyph, FT_LOAD_NO_HINTING, &advance));
    return advance;
  }

  struct Close {
    void operator()(FT_Library library) const { FT_Done_FreeType(library); }
    void operator()(FT_Face face) const { FT_Done_Face(face); }
  };
  int size;
  std::unique_ptr<std::remove_pointer_t<FT_Library>, Close> library;
  std::unique_ptr<std::remove_pointer_t<FT_Face>, Close> face;  // closed before the library
};

TextFont::TextFont(int size) : state_(std::make_unique<State>(size)) {}
TextFont::~TextFont() = default;

int TextFont::ascent() const { return int(std::ceil(kAscent * state_->size)); }
int TextFont::height() const { return ascent() + int(std::ceil(kDescent * state_->size)); }

int TextFont::width(std::string_view text) const {
  int64_t sum = 0;
  while (!text.empty()) sum += state_->advance_of(state_->glyph_of(pop_character(&text)));
  return int((sum + 0xffff) >> 16);
}

void TextFont::draw(BytePicture& picture, int x, int y, std::string_view text,
                    const Rgb8& colour) const {
  FT_GlyphSlot slot = state_->face->glyph;
  int64_t pen = 0;
  while (!text.empty()) {
    const FT_UInt glyph = state_->glyph_of(pop_character(&text));
    check(FT_Load_Glyph(state_->face.get(), glyph, FT_LOAD_NO_HINTING));
    // Lets glyphs begin between pixels, because rounding to whole pixels would space small letters
    // unevenly. FreeType's unit here is 1/64 of a pixel.
    FT_Outline_Translate(&slot->outline, FT_Pos((pen & 0xffff) >> 10), 0);
    check(FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL));
    blend(picture, x + int(pen >> 16) + slot->bitmap_left, y + ascent() - slot->bitmap_top,
          slot->bitmap, colour);
    pen += state_->advance_of(glyph);
  }
}

bool TextFont::has(char32_t character) const {
  return FT_Get_Char_Index(state_->face.get(), character) != 0;
}

}  // namespace emberline
