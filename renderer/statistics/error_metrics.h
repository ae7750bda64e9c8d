// How far an image is from a reference. Images are linear RGB, interleaved, row-major; both of the
// same size. Non-finite pixels are counted and left out of every mean (and fail is_comparable).
#pragma once

#include <cstdint>
#include <vector>

namespace emberline {

struct RgbImage {
  int width = 0, height = 0;
  std::vector<float> rgb;
};

struct ErrorMetrics {
  double mse = 0;               // mean over pixels and channels
  double rmse = 0;
  double rel_mse = 0;           // mean((x - r)^2 / (r^2 + eps)), eps = 0.01 (mean r)^2, as stated
  double rel_mse_epsilon = 0;
  double rel_mse_trimmed = 0;   // without the worst 0.1 % of pixels
  double signed_bias = 0;       // sum(x - r) / sum(r)
  double psnr = 0;              // dB, on display (sRGB) values, peak 1; infinite if equal
  double ssim = 0;              // Wang et al. 2004, 11x11 Gaussian, on display luma
  double flip = 0;              // mean LDR-FLIP, Andersson et al. 2020, 67 pixels per degree
  double max_absolute = 0;
  uint64_t non_finite = 0;      // pixels with a NaN or infinity in either image
  uint64_t different_pixels = 0;  // not bit-identical
};

ErrorMetrics compare_images(const RgbImage& image, const RgbImage& reference);

// Per-pixel FLIP in [0, 1] (display-referred input, sRGB-encoded values in [0, 1]).
std::vector<float> flip_map(const RgbImage& image, const RgbImage& reference);

}  // namespace emberline
