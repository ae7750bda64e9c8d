// Structural similarity: Wang, Bovik, Sheikh & Simoncelli 2004, "Image Quality Assessment: From
// Error Visibility to Structural Similarity", IEEE TIP 13(4).
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

// Returns the mean SSIM of two planes of width x height values in [0, 1], row-major. Uses a
// Gaussian window of 11 x 11 pixels with sigma 1.5, K1 = 0.01 and K2 = 0.03 (section III.C). If a
// side of the image is shorter than 11 pixels, the window is as long as that side. Windows that
// extend beyond the image or contain a pixel whose `masked` is nonzero are excluded. If no window
// remains, returns NaN. Swapping a and b changes the result at most by rounding. Runs in parallel;
// the result is deterministic.
double mean_ssim(const std::vector<float>& a, const std::vector<float>& b,
                 const std::vector<uint8_t>& masked, int width, int height);

}  // namespace emberline
