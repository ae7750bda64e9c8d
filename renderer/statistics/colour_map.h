// Colour maps, which convert a number in [0, 1] to a display colour in 8-bit sRGB.
//
// viridis, inferno and magma are from S. van der Walt and N. Smith 2015, "mpl colormaps", CC0.
// Their steps are perceptually even (CAM02-UCS) and their lightness rises, so they can be read by
// colour-blind readers and in a grey print. turbo is from A. Mikhailov 2019, "Turbo, an improved
// rainbow colormap for visualization", Google AI Blog; Apache-2.0. With turbo, more values can be
// told apart, but a brighter colour does not mean a larger value.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace emberline {

using Rgb8 = std::array<uint8_t, 3>;

enum class ColourMap : uint8_t { kGrey, kViridis, kInferno, kMagma, kTurbo };

struct ColourMapEntry {
  std::string_view name;
  std::string_view summary;
  ColourMap map;
  Rgb8 no_value;  // for pixels without a value; differs from every colour of the map
};
// The table from which --colors, its help and its error message are made, in the order of
// ColourMap.
std::span<const ColourMapEntry> colour_map_table();
ColourMap parse_colour_map(std::string_view name);  // throws UsageError

// Returns the colour of `value`, which is clamped to [0, 1]. Returns the map's no_value for NaN.
// Interpolates between 33 samples of each published table; the error is at most 2 of 255 levels.
Rgb8 colour_of(ColourMap map, double value);

}  // namespace emberline
