// emberline compare: how far one picture is from another.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/app/run_limits.h"
#include "renderer/statistics/error_metrics.h"

namespace emberline {

struct CompareOptions {
  std::string image;
  std::string reference;
  bool json = false;       // to stdout, instead of a table
  std::string difference;  // empty: none; .png/.jpg: FLIP in false colour; .exr: image - reference
  float exposure = 0.0f;   // stops, for PSNR, SSIM, FLIP and the FLIP picture
  LimitOptions limits;
};

// Reads both pictures (whatever OpenImageIO reads; 8-bit ones as sRGB, channels R, G and B), prints
// the metrics of renderer/statistics/error_metrics.h to stdout and writes the difference picture.
//
// JSON: one object with the keys width, height, mse, rmse, relmse, relmse_epsilon, relmse_trimmed,
// signed_bias, psnr, ssim, flip, max_abs, non_finite, different_pixels. A metric without a finite
// value is null: the PSNR of equal pictures, the signed bias against black, and all of them when no
// pixel is finite in both.
//
// FLIP picture: black (0) over purple and orange to light yellow (1), the colours of magma; pixels
// that are not finite are green. EXR: channels R, G, B, unclamped, and "flip".
//
// Returns kExitDone; how different the pictures are does not change the exit code. Throws
// InputError (unreadable, channels missing, sizes differ), UsageError (suffix of the difference
// picture, exposure), RenderError (cannot write it).
int run_compare(const CompareOptions& options);

// The FLIP picture above: `flip` per pixel of a picture of that size, `masked` not 0 where it is
// not finite. Throws UsageError for the suffix, RenderError.
void write_flip_picture(const std::string& path, const RgbImage& image,
                        const std::vector<float>& flip, const std::vector<uint8_t>& masked);

}  // namespace emberline
