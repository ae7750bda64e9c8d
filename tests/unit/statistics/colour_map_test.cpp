// Compares colour maps with the published tables, and tests their perceptual properties.
#include "renderer/statistics/colour_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderer/core/errors.h"
#include "support/colour_vision.h"

namespace emberline::test {
namespace {

struct Published {
  ColourMap map;
  std::vector<std::pair<int, Rgb8>> entries;  // of a table of 256
};

// The entries are from Mikhailov's table and from matplotlib's tables, the original source of
// viridis, inferno and magma. They are the ends, the four entries with the largest error between
// our samples, and six others.
const std::vector<Published>& published() {
  static const std::vector<Published> tables = {
      {ColourMap::kViridis,
       {{0, {68, 1, 84}},
        {20, {72, 29, 111}},
        {61, {60, 79, 138}},
        {100, {42, 118, 142}},
        {130, {32, 146, 140}},
        {188, {86, 198, 103}},
        {215, {149, 216, 64}},
        {242, {221, 227, 24}},
        {243, {223, 227, 24}},
        {244, {226, 228, 24}},
        {245, {229, 228, 25}},
        {255, {253, 231, 37}}}},
      {ColourMap::kInferno,
       {{0, {0, 0, 4}},
        {3, {1, 1, 8}},
        {20, {16, 9, 45}},
        {61, {82, 14, 109}},
        {100, {144, 37, 104}},
        {130, {191, 57, 82}},
        {188, {248, 135, 14}},
        {194, {250, 146, 7}},
        {195, {250, 148, 7}},
        {203, {252, 163, 9}},
        {215, {251, 186, 31}},
        {255, {252, 255, 164}}}},
      {ColourMap::kMagma,
       {{0, {0, 0, 4}},
        {1, {1, 0, 5}},
        {2, {1, 1, 6}},
        {3, {1, 1, 8}},
        {4, {2, 1, 9}},
        {20, {14, 11, 43}},
        {61, {76, 17, 122}},
        {100, {137, 40, 129}},
        {130, {186, 56, 120}},
        {188, {250, 129, 95}},
        {215, {254, 180, 123}},
        {255, {252, 253, 191}}}},
      {ColourMap::kTurbo,
       {{0, {48, 18, 59}},
        {20, {66, 75, 181}},
        {61, {46, 180, 242}},
        {82, {24, 224, 189}},
        {83, {25, 226, 187}},
        {84, {25, 227, 185}},
        {85, {26, 228, 182}},
        {100, {63, 246, 138}},
        {130, {169, 251, 57}},
        {188, {253, 138, 38}},
        {215, {225, 65, 9}},
        {255, {122, 4, 3}}}},
  };
  return tables;
}

TEST(ColourMap, IsWithinTwoStepsOfThePublishedTables) {
  for (const Published& table : published()) {
    for (const auto& [index, expected] : table.entries) {
      const Rgb8 colour = colour_of(table.map, index / 255.0);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(colour[c], expected[c], 2) << colour_map_table()[size_t(table.map)].name
                                               << ", entry " << index << ", channel " << c;
      }
    }
  }
}

TEST(ColourMap, GreyIsLinearInDisplayValues) {
  EXPECT_EQ(colour_of(ColourMap::kGrey, 0.0), (Rgb8{0, 0, 0}));
  EXPECT_EQ(colour_of(ColourMap::kGrey, 0.2), (Rgb8{51, 51, 51}));
  EXPECT_EQ(colour_of(ColourMap::kGrey, 1.0), (Rgb8{255, 255, 255}));
}

TEST(ColourMap, LightnessRisesInAllButTurbo) {
  for (const ColourMapEntry& entry : colour_map_table()) {
    bool rises = true;
    double span = 0;
    for (int i = 1; i <= 64; ++i) {
      const double step = lightness(colour_of(entry.map, i / 64.0)) -
                          lightness(colour_of(entry.map, (i - 1) / 64.0));
      rises = rises && step > 0.0;
      span += step;
    }
    EXPECT_EQ(rises, entry.map != ColourMap::kTurbo) << entry.name;
    if (rises) {
      EXPECT_GT(span, 70.0) << entry.name << ": too little to read it in grey";
    }
  }
}

// CIE 1976 differences below 10 are small, and differences above 20 are obvious.
TEST(ColourMap, NoValueIsLikeNoValueOfTheMap) {
  for (const ColourMapEntry& entry : colour_map_table()) {
    for (int i = 0; i <= 255; ++i) {
      ASSERT_GT(min_difference(entry.no_value, colour_of(entry.map, i / 255.0)), 20.0)
          << entry.name << " at " << i << " of 255";
    }
    EXPECT_EQ(colour_of(entry.map, NAN), entry.no_value);
  }
}

TEST(ColourMap, ValuesOutsideHaveTheColoursOfTheEnds) {
  for (const ColourMapEntry& entry : colour_map_table()) {
    EXPECT_EQ(colour_of(entry.map, -0.5), colour_of(entry.map, 0.0));
    EXPECT_EQ(colour_of(entry.map, -INFINITY), colour_of(entry.map, 0.0));
    EXPECT_EQ(colour_of(entry.map, 1.5), colour_of(entry.map, 1.0));
    EXPECT_EQ(colour_of(entry.map, INFINITY), colour_of(entry.map, 1.0));
  }
}

TEST(ColourMap, TheTableIsInTheOrderOfTheEnumeration) {
  for (size_t i = 0; i < colour_map_table().size(); ++i) {
    EXPECT_EQ(size_t(colour_map_table()[i].map), i);
    EXPECT_EQ(parse_colour_map(colour_map_table()[i].name), ColourMap(i));
  }
  EXPECT_THROW(parse_colour_map("jet"), UsageError);
}

}  // namespace
}  // namespace emberline::test
