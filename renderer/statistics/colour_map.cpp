#include "renderer/statistics/colour_map.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/names.h"

namespace emberline {
namespace {

// Colours 0xRRGGBB in even steps from 0 to 1, sampled from the published tables of 256 colours.
constexpr size_t kSamples = 33;
using Table = std::array<uint32_t, kSamples>;
constexpr Table kViridis = {0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453681, 0x424086,
                            0x3f4989, 0x3b528b, 0x375a8d, 0x33638d, 0x2f6a8e, 0x2c728e, 0x297a8e,
                            0x26818e, 0x23898e, 0x21908c, 0x1f988b, 0x1f9f88, 0x21a685, 0x28ae80,
                            0x31b57b, 0x3ebc74, 0x4cc26c, 0x5dc963, 0x6ece58, 0x82d34c, 0x96d83f,
                            0xabdc32, 0xc0df24, 0xd5e21a, 0xeae51a, 0xfde725};
constexpr Table kInferno = {0x000004, 0x040312, 0x0b0724, 0x150b37, 0x210c4a, 0x2e0a5a, 0x3c0965,
                            0x4a0c6b, 0x57106d, 0x63146e, 0x70196e, 0x7d1e6d, 0x89226a, 0x962766,
                            0xa32b61, 0xaf315c, 0xbb3755, 0xc63e4d, 0xd14644, 0xdb4f3b, 0xe35932,
                            0xeb6528, 0xf1711e, 0xf67f14, 0xf98d0a, 0xfb9c06, 0xfcab0f, 0xfbba1f,
                            0xf9ca32, 0xf5d949, 0xf2e865, 0xf3f586, 0xfcffa4};
constexpr Table kMagma = {0x000004, 0x030311, 0x0a0822, 0x130d33, 0x1d1146, 0x28115a, 0x36106a,
                          0x430f76, 0x50127c, 0x5d177f, 0x691c81, 0x762181, 0x822681, 0x8f2a81,
                          0x9c2e7f, 0xa9327d, 0xb63779, 0xc33b75, 0xcf4170, 0xdb486a, 0xe65163,
                          0xee5c5e, 0xf5695c, 0xf9785d, 0xfb8761, 0xfd9668, 0xfea571, 0xfeb47b,
                          0xfec387, 0xfed194, 0xfde0a2, 0xfceeb0, 0xfcfdbf};
constexpr Table kTurbo = {0x30123b, 0x392a73, 0x4040a1, 0x4456c7, 0x466be3, 0x467ff6, 0x4293ff,
                          0x37a7fa, 0x29bbec, 0x1dcdd8, 0x18dcc3, 0x1ee8b0, 0x31f299, 0x4cf97e,
                          0x6bfd64, 0x8aff4d, 0xa3fd3c, 0xb8f735, 0xcced34, 0xdee037, 0xedd03a,
                          0xf8c03a, 0xfdae35, 0xfe982c, 0xfb8022, 0xf56817, 0xec520f, 0xe04009,
                          0xd23105, 0xc02302, 0xac1701, 0x950d01, 0x7a0403};

constexpr const Table* kTables[] = {nullptr, &kViridis, &kInferno, &kMagma, &kTurbo};

// We chose each no_value from a grid of colours. It has the largest CIELAB distance from the
// colours of its map, in normal vision as well as with protanopia, deuteranopia and tritanopia.
// Magma is an exception: its green has a distance of 33, and the largest distance is 40.
constexpr ColourMapEntry kMaps[] = {
    {"grey", "black to white; brighter means more", ColourMap::kGrey, {255, 102, 0}},
    {"viridis", "dark violet through green to yellow", ColourMap::kViridis, {204, 0, 255}},
    {"inferno", "black through red to light yellow", ColourMap::kInferno, {0, 255, 255}},
    {"magma", "black through purple to light yellow", ColourMap::kMagma, {0, 255, 0}},
    {"turbo",
     "a rainbow: separates the most values, but not by brightness",
     ColourMap::kTurbo,
     {153, 102, 102}},
};

double channel_of(uint32_t colour, size_t c) { return double((colour >> (16 - 8 * c)) & 0xff); }

Rgb8 interpolate(const Table& table, double value) {
  const double position = value * double(kSamples - 1);
  const size_t step = std::min(size_t(position), kSamples - 2);
  Rgb8 colour{};
  for (size_t c = 0; c < 3; ++c) {
    const double a = channel_of(table[step], c), b = channel_of(table[step + 1], c);
    colour[c] = uint8_t(std::lround(std::lerp(a, b, position - double(step))));
  }
  return colour;
}

}  // namespace

std::span<const ColourMapEntry> colour_map_table() { return kMaps; }

ColourMap parse_colour_map(std::string_view name) {
  return find_named(kMaps, "`colors`", "colour map", name).map;
}

Rgb8 colour_of(ColourMap map, double value) {
  if (std::isnan(value)) return kMaps[size_t(map)].no_value;
  const double x = std::clamp(value, 0.0, 1.0);
  if (const Table* const table = kTables[size_t(map)]) return interpolate(*table, x);
  const auto grey = uint8_t(std::lround(255 * x));
  return {grey, grey, grey};
}

}  // namespace emberline
