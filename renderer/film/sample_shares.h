// Weights of a sample for the pixels around it.
#pragma once

#include <array>
#include <cstddef>

namespace emberline {

// Weights for the sample's own pixel and its eight neighbours, row by row from the upper left; see
// PixelFilter::shares().
inline constexpr size_t kSharedPixels = 9;
using SampleShares = std::array<float, kSharedPixels>;

}  // namespace emberline
