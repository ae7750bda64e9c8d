// Structural similarity: Wang, Bovik, Sheikh & Simoncelli 2004, "Image Quality Assessment: From
// Error Visibility to Structural Similarity", IEEE TIP 13(4).
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

// Mean SSIM of two planes of width x height values in [0, 1], row-major. The window is Gaussian, 11
// x 11 with sigma 1.5, K1 = 0.01 and K2 = 0.03 (section III.C); where a side of the image is
// shorter than 11, the window has the length of that side. Windows that extend beyond the image or
// contain a pixel whose `masked` is nonzero are excluded; if none remain, the result is NaN.
// Symmetric in a and b up to rounding. Parallel and deterministic.
double mean_ssim(const std::vector<float>& a, const std::vector<float>& b,
                 const std::vector<uint8_t>& masked, int width, int height);

}  // namespace emberline
