// Error metrics of an image against a reference. Both images are linear RGB, interleaved and
// row-major, and have the same size.
//
// Pixels with a NaN or infinity in either image are counted in `non_finite` and excluded from every
// mean. The two metrics that look at neighbourhoods treat these pixels as follows: FLIP makes them
// black in both images and excludes their own FLIP values; SSIM excludes every window that contains
// one of them. If no pixel remains (for SSIM, no window), a metric is NaN.
//
// Runs in parallel; the result is bit-identical for any number of threads, since each row is summed
// in double by one thread, and the sums of the rows are added in order.
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
  // Exposure in stops, for the metrics of the displayed picture: PSNR, SSIM and FLIP.
  float exposure = 0.0f;
};

struct ErrorMetrics {
  double mse = kNone;  // mean((x - r)^2) over pixels and channels
  double rmse = kNone;
  // mean((x - r)^2 / (r^2 + eps)), averaged over channels, as in Rousselle et al. 2011. eps is 0.01
  // (mean r)^2, so that the metric does not depend on the scale of radiance. If mean r is 0, eps is
  // 0.01.
  double rel_mse = kNone;
  double rel_mse_epsilon = kNone;
  double rel_mse_trimmed = kNone;  // without the worst 0.1 % of pixels (rounded down)
  double signed_bias = kNone;      // sum(x - r) / sum(r); x / 0 is infinite, 0 / 0 is 0
  double psnr = kNone;             // dB, display values, peak 1; infinite if there is no difference
  double ssim = kNone;             // ssim.h, on the luma of display values
  double flip = kNone;             // mean of flip_map() (flip.h)
  double max_absolute = kNone;     // largest |x - r|
  uint64_t non_finite = 0;         // pixels with a NaN or infinity in either image
  uint64_t different_pixels = 0;   // not bit-identical

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
};

// Upper bound on the bytes per pixel that a comparison of two pictures allocates: it makes
// display-encoded copies of both, and maps for FLIP and SSIM. We measured 50 bytes.
inline constexpr uint64_t kComparisonBytesPerPixel = 64;

// The fraction of pixels that rel_mse_trimmed excludes, and epsilon for a black reference. Both
// values are our own choice.
inline constexpr double kTrimmedFraction = 0.001, kBlackEpsilon = 0.01;

// The images must not be empty and must have equal size (asserted).
ErrorMetrics compare_images(const RgbImage& image, const RgbImage& reference,
                            const CompareSettings& settings = {});

// Returns the mean of the values after removing the largest ones, which are a fraction
// kTrimmedFraction of all values. There must be at least one value.
double trimmed_mean(std::vector<double> values);

// Returns 1 for each pixel that has a NaN or infinity in either image, else 0.
std::vector<uint8_t> non_finite_pixels(const RgbImage& image, const RgbImage& reference);

// Multiplies the image by 2^exposure and returns it as sRGB-encoded values (IEC 61966-2-1), clamped
// to [0, 1]. Pixels whose `masked` is nonzero are black.
RgbImage to_display(const RgbImage& image, float exposure, const std::vector<uint8_t>& masked);

}  // namespace emberline
