// emberline compare: how far one picture is from another.
#pragma once

#include <string>

#include "renderer/engine/run_limits.h"

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
// FLIP picture: that of renderer/output/flip_picture.h. EXR: channels R, G, B, unclamped, and
// "flip".
//
// Returns kExitDone; how different the pictures are does not change the exit code. Throws
// InputError (unreadable, channels missing, sizes differ), UsageError (suffix of the difference
// picture, exposure), RenderError (cannot write it).
int run_compare(const CompareOptions& options);

}  // namespace emberline
