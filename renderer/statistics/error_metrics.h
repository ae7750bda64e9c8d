// Error metrics of an image against a reference. Images are linear RGB, interleaved, row-major, of
// the same size.
//
// Pixels with a NaN or infinity in either image are counted in `non_finite` and excluded from every
// mean. For metrics over neighbourhoods: FLIP treats them as black in both images (and excludes
// their own FLIP value), SSIM excludes every window that contains one. Without any remaining pixel
// (for SSIM: window) a metric is NaN.
//
// Parallel, with the same bits for any number of threads: each row is summed in double by one
// thread, then rows are added in order.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace emberline {

struct RgbImage {
  int width = 0, height = 0;
  std::vector<float> rgb;  // 3 * width * height
};

struct CompareSettings {
  // Stops, for the metrics of the displayed picture: PSNR, SSIM and FLIP.
  float exposure = 0.0f;
};

// NaN if no pixel remains.
struct ErrorMetrics {
  double mse = kNone;  // mean((x - r)^2) over pixels and channels
  double rmse = kNone;
  // mean((x - r)^2 / (r^2 + eps)), averaged over channels, as in Rousselle et al. 2011. eps = 0.01
  // (mean r)^2, so that the metric does not depend on the scale of radiance; 0.01 if the reference
  // is black on average.
  double rel_mse = kNone;
  double rel_mse_epsilon = kNone;
  double rel_mse_trimmed = kNone;  // without the worst 0.1 % of pixels (rounded down)
  double signed_bias = kNone;      // sum(x - r) / sum(r); infinite for a difference from black
  double psnr = kNone;             // dB, display values, peak 1; infinite for equal images
  double ssim = kNone;             // ssim.h, on the luma of display values
  double flip = kNone;             // mean of flip.h's map
  double max_absolute = kNone;     // largest |x - r|
  uint64_t non_finite = 0;         // pixels with a NaN or infinity in either image
  uint64_t different_pixels = 0;   // not bit-identical

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
};

// Upper bound for the additional memory of comparing two pictures (50 were measured): displayed
// copies and maps of FLIP and SSIM.
inline constexpr uint64_t kComparisonBytesPerPixel = 64;

// Our choices: the share of pixels that rel_mse_trimmed excludes, and epsilon for a black
// reference.
inline constexpr double kTrimmedFraction = 0.001, kBlackEpsilon = 0.01;

// Images are not empty and of equal size (asserted).
ErrorMetrics compare_images(const RgbImage& image, const RgbImage& reference,
                            const CompareSettings& settings = {});

// 1 for pixels that are not finite in either image.
std::vector<uint8_t> non_finite_pixels(const RgbImage& image, const RgbImage& reference);

// sRGB-encoded values (IEC 61966-2-1) in [0, 1], after 2^exposure; black where `masked` is nonzero.
RgbImage to_display(const RgbImage& image, float exposure, const std::vector<uint8_t>& masked);

}  // namespace emberline
