// The sRGB curve and its tables for integer texels.
#pragma once

#include <vector>

namespace emberline {

// Converts an encoded value in [0, 1] to a linear one in [0, 1] (IEC 61966-2-1).
double srgb_to_linear(double encoded);

// Values of all 8-bit codes: linear light for colour, code / 255 for data.
const std::vector<float>& srgb8_table();
const std::vector<float>& linear8_table();

// Values of all 16-bit sRGB codes: 256 KiB, built (2 ms) for the first 16-bit colour texture.
const std::vector<float>& srgb16_table();

}  // namespace emberline
