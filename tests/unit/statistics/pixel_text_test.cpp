// Text without font files: all characters are distinguishable, and text stays in its place.
#include "renderer/statistics/pixel_text.h"

#include <gtest/gtest.h>

#include <string>

#include "support/find_text.h"

namespace emberline::test {
namespace {

constexpr Rgb8 kPaper = {10, 20, 30}, kInk = {250, 240, 230};

int ink_of(char c) {
  int ink = 0;
  for (int y = 0; y < kGlyphHeight; ++y) {
    for (int x = 0; x < kGlyphWidth; ++x) ink += glyph_ink(c, x, y);
  }
  return ink;
}

int pixels_apart(char a, char b) {
  int apart = 0;
  for (int y = 0; y < kGlyphHeight; ++y) {
    for (int x = 0; x < kGlyphWidth; ++x) apart += glyph_ink(a, x, y) != glyph_ink(b, x, y);
  }
  return apart;
}

TEST(PixelText, EveryCharacterHasAUniqueShape) {
  EXPECT_EQ(ink_of(' '), 0);
  for (char a = '!'; a <= '~'; ++a) {
    EXPECT_GE(ink_of(a), 3) << a;
    EXPECT_LE(ink_of(a), 21) << a << " is a blot";
    for (char b = '!'; b < a; ++b) EXPECT_GE(pixels_apart(a, b), 2) << a << " and " << b;
  }
}

// Characters that readers often confuse.
TEST(PixelText, LookalikesAreFarApart) {
  for (const char* pair : {"0O", "0D", "O0", "1l", "1I", "Il", "1i", "5S", "8B", "2Z", "6b", "9g",
                           "38", "56", "17", "uv", "ce", ".,"}) {
    EXPECT_GE(pixels_apart(pair[0], pair[1]), pair[0] == '.' ? 2 : 3) << pair;
  }
}

TEST(PixelText, OnlyLettersWithDescendersGoBelowTheLine) {
  for (char c = ' '; c <= '~'; ++c) {
    bool below = false;
    for (int x = 0; x < kGlyphWidth; ++x) {
      below = below || glyph_ink(c, x, 7) || glyph_ink(c, x, 8);
    }
    EXPECT_EQ(below, std::string(",;_gjpqy|").find(c) != std::string::npos) << c;
  }
}

TEST(PixelText, BeyondAsciiIsAQuestionMark) {
  for (const char c : {'\n', '\x7f', '\xc3', '\0'}) EXPECT_EQ(pixels_apart(c, '?'), 0);
}

TEST(PixelText, WidthMatchesTheDrawnText) {
  EXPECT_EQ(text_width("", 3), 0);
  EXPECT_EQ(text_width("H", 1), 5);
  EXPECT_EQ(text_width("HH", 1), 11);
  EXPECT_EQ(text_width("HHH", 4), 68);
  for (const int scale : {1, 2, 5}) {
    const std::string text = "HgH";
    const int width = text_width(text, scale), height = text_height(scale);
    BytePicture picture(width + 20, height + 20, kPaper);
    draw_text(picture, 10, 10, text, scale, kInk);
    Rect ink{1000, 1000, 0, 0};
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        if (picture.colour(x, y) == kPaper) continue;
        ASSERT_EQ(picture.colour(x, y), kInk);
        ink = {std::min(ink.x0, x), std::min(ink.y0, y), std::max(ink.x1, x + 1),
               std::max(ink.y1, y + 1)};
      }
    }
    EXPECT_EQ(ink, (Rect{10, 10, 10 + width, 10 + height})) << "scale " << scale;
    EXPECT_TRUE(shows_text(picture, text, scale));
    EXPECT_FALSE(shows_text(picture, "HqH", scale));
  }
}

TEST(PixelText, TextIsClippedToThePicture) {
  for (const int x : {-1000, -7, -1, 15, 1000}) {
    for (const int y : {-1000, -4, 12, 1000}) {
      BytePicture picture(16, 16, kPaper);
      draw_text(picture, x, y, "WWWWWW", 2, kInk);  // sanitizers check the bounds
      EXPECT_EQ(picture.values.size(), 3u * 16 * 16);
    }
  }
}

}  // namespace
}  // namespace emberline::test
