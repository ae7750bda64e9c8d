// Colour maps: from a number in [0, 1] to a display colour, 8-bit sRGB.
//
// viridis, inferno, magma: S. van der Walt and N. Smith 2015, "mpl colormaps", CC0: perceptually
// even steps (CAM02-UCS) and rising lightness, readable for colour-blind readers and in grey print.
// turbo: A. Mikhailov 2019, "Turbo, an improved rainbow colormap for visualization", Google AI
// Blog; Apache-2.0: distinguishes more values, but brighter does not mean more.
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
  Rgb8 no_value;  // for pixels without a value: far from every colour of the map
};
// The table behind --colors, its --help and its error message, in enumeration order.
std::span<const ColourMapEntry> colour_map_table();
ColourMap parse_colour_map(std::string_view name);  // throws UsageError

// The colour of `value`, clamped to [0, 1]; the map's no_value for NaN. Interpolates 33 samples of
// the published tables; the error is at most 2 of 255.
Rgb8 colour_of(ColourMap map, double value);

}  // namespace emberline
