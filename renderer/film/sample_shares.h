// How a sample counts for the pixels around its own (PixelFilter::shares).
#pragma once

#include <array>
#include <cstddef>

namespace emberline {

// What a sample counts for the pixel it was drawn for and for the eight around that one, row by row
// from the upper left: PixelFilter::shares().
inline constexpr size_t kSharing = 9;
using SampleShares = std::array<float, kSharing>;

}  // namespace emberline
