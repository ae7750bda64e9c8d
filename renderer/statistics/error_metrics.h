// How far an image is from a reference. Images are linear RGB, interleaved, row-major; both of the
// same size.
//
// A pixel with a NaN or an infinity in either image is counted in `non_finite` and left out of
// every mean. For the metrics that look at neighbourhoods it is black in both pictures for FLIP
// (and its own FLIP value left out), and SSIM leaves out every window that contains it. With no
// pixel left (or for SSIM no window) a metric is NaN.
//
// Parallel, yet the same bits for any number of threads: rows are summed in double, each by one
// thread, and then added in order.
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
  // Stops, for the metrics that look at the picture as displayed: PSNR, SSIM and FLIP.
  float exposure = 0.0f;
};

// NaN: no pixel is left to say.
struct ErrorMetrics {
  double mse = kNone;  // mean((x - r)^2) over pixels and channels
  double rmse = kNone;
  // mean((x - r)^2 / (r^2 + eps)), per channel averaged, as in Rousselle et al. 2011; eps =
  // 0.01 (mean r)^2, so that the metric does not depend on the scale of radiance, or 0.01 where the
  // reference is black on average.
  double rel_mse = kNone;
  double rel_mse_epsilon = kNone;
  double rel_mse_trimmed = kNone;  // without the worst 0.1 % of pixels (rounded down)
  double signed_bias = kNone;      // sum(x - r) / sum(r); infinite for a difference from black
  double psnr = kNone;             // dB, display values, peak 1; infinite if they are equal
  double ssim = kNone;             // ssim.h, on the luma of display values
  double flip = kNone;             // mean of flip.h's map
  double max_absolute = kNone;     // largest |x - r|
  uint64_t non_finite = 0;         // pixels with a NaN or infinity in either image
  uint64_t different_pixels = 0;   // not bit-identical

  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
};

// Memory that comparing two pictures takes beside them, at most (50 were measured): displayed
// copies and maps of FLIP and SSIM.
inline constexpr uint64_t kComparisonBytesPerPixel = 64;

// We chose: the share of pixels that rel_mse_trimmed leaves out, and epsilon for a black reference.
inline constexpr double kTrimmedShare = 0.001, kBlackEpsilon = 0.01;

// Neither image may be empty; sizes equal (asserted).
ErrorMetrics compare_images(const RgbImage& image, const RgbImage& reference,
                            const CompareSettings& settings = {});

// 1 for the pixels that are not finite in either image.
std::vector<uint8_t> non_finite_pixels(const RgbImage& image, const RgbImage& reference);

// sRGB-encoded values (IEC 61966-2-1) in [0, 1], after 2^exposure; black where `masked` is not 0.
RgbImage to_display(const RgbImage& image, float exposure, const std::vector<uint8_t>& masked);

}  // namespace emberline
