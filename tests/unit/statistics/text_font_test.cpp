// Tests text in pictures: its characters, its sizes, and ink inside its box.
#include "renderer/statistics/text_font.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

namespace emberline::test {
namespace {

constexpr Rgb8 kPaper = {10, 20, 30}, kInk = {250, 240, 230};

BytePicture drawn(const std::string& text, int size) {
  const TextFont font(size);
  BytePicture picture(font.width(text) + 20, font.height() + 20, kPaper);
  font.draw(picture, 10, 10, text, kInk);
  return picture;
}

// Returns the smallest rectangle around everything that is not paper.
Rect ink_of(const BytePicture& picture) {
  Rect ink{picture.width, picture.height, 0, 0};
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture.colour(x, y) == kPaper) continue;
      ink = {std::min(ink.x0, x), std::min(ink.y0, y), std::max(ink.x1, x + 1),
             std::max(ink.y1, y + 1)};
    }
  }
  return ink;
}

TEST(TextFont, HasAsciiAndTheSignsOfOurLabels) {
  const TextFont font(11);
  for (char32_t c = U' '; c <= U'~'; ++c) EXPECT_TRUE(font.has(c)) << int(c);
  for (const char32_t c : U"\u00a0°±²³µ·¹×σ–…⁰⁴⁵⁶⁷⁸⁹⁻−√≈≤≥") {
    if (c != 0) {
      EXPECT_TRUE(font.has(c)) << int(c);
    }
  }
  EXPECT_FALSE(font.has(U'Ω'));
}

TEST(TextFont, EveryCharacterHasItsOwnShape) {
  std::vector<std::vector<uint8_t>> shapes;
  for (char c = '!'; c <= '~'; ++c) {
    BytePicture picture(30, 30, kPaper);
    TextFont(11).draw(picture, 5, 5, std::string(1, c), kInk);
    EXPECT_EQ(std::ranges::count(shapes, picture.values), 0) << c;
    shapes.push_back(picture.values);
  }
}

TEST(TextFont, UnknownCharactersAndInvalidBytesAreQuestionMarks) {
  const auto wanted = drawn("a?b", 20).values;
  for (const char* text : {"aΩb",
                           "a\xff"
                           "b",
                           "a\nb"})
    EXPECT_EQ(drawn(text, 20).values, wanted);
}

TEST(TextFont, SignsOfSeveralBytesAreOneCharacter) {
  const TextFont font(40);
  EXPECT_LT(font.width("µ"), 40);
  EXPECT_LT(font.width("10⁻⁷"), 120);
}

TEST(TextFont, InkStaysInTheBox) {
  for (const int size : {8, 11, 18, 54, 200}) {
    const std::string text = "Ågj|(10⁻⁷) √µ_`";
    const TextFont font(size);
    const Rect ink = ink_of(drawn(text, size));
    EXPECT_GE(ink.y0, 10) << size;
    EXPECT_LE(ink.y1, 10 + font.height()) << size;
    EXPECT_GE(ink.x0, 10) << size;
    EXPECT_LE(ink.x1, 10 + font.width(text)) << size;
    // The box is not much larger than the ink, either.
    EXPECT_GT(ink.width(), font.width(text) * 9 / 10) << size;
    EXPECT_GT(ink.height(), font.height() * 8 / 10) << size;
  }
}

TEST(TextFont, GrowsInProportion) {
  const std::string text = "1,024 samples per pixel";
  const int width = TextFont(200).width(text);
  for (const int size : {11, 18, 54}) {
    EXPECT_NEAR(TextFont(size).width(text), width * size / 200.0, 1.0) << size;
  }
  EXPECT_EQ(TextFont(18).width(""), 0);
}

TEST(TextFont, LettersStandOnTheBaseline) {
  const TextFont font(54);
  EXPECT_EQ(ink_of(drawn("HTI", 54)).y1, 10 + font.ascent());
  EXPECT_GT(ink_of(drawn("gpq", 54)).y1, 10 + font.ascent());
}

TEST(TextFont, EdgesAreSmooth) {
  const BytePicture picture = drawn("O", 20);
  int between = 0, full = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Rgb8 colour = picture.colour(x, y);
      full += colour == kInk;
      between += colour != kInk && colour != kPaper;
    }
  }
  EXPECT_GT(between, 20);
  EXPECT_GT(full, 10);
}

TEST(TextFont, TextOutsideThePictureIsCutOff) {
  for (const int x : {-1000, -7, -1, 15, 1000}) {
    for (const int y : {-1000, -4, 12, 1000}) {
      BytePicture picture(16, 16, kPaper);
      TextFont(20).draw(picture, x, y, "WWWWWW", kInk);  // sanitizers check the bounds
      EXPECT_EQ(picture.values.size(), 3u * 16 * 16);
    }
  }
}

TEST(TextFont, ThreadsDrawTheSameBytes) {
  const auto wanted = drawn("maximum 1,024", 18).values;
  std::vector<std::vector<uint8_t>> found(4);
  {
    std::vector<std::jthread> threads;
    for (auto& values : found) {
      threads.emplace_back([&values] {
        for (int i = 0; i < 20; ++i) values = drawn("maximum 1,024", 18).values;
      });
    }
  }
  for (const auto& values : found) EXPECT_EQ(values, wanted);
}

}  // namespace
}  // namespace emberline::test
