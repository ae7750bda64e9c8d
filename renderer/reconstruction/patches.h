// Similarity of the patches around two pixels, as in non-local means (Buades et al. 2005), but with
// the contribution of noise subtracted from each difference (Rousselle et al. 2012).
#pragma once

#include <algorithm>
#include <bit>

#include "renderer/reconstruction/tiles.h"

namespace emberline {

inline constexpr int kPatchRadius = 3;  // for colour; Rousselle et al. 2012, §5
inline constexpr int kPatchPad = 8;     // extra columns on either side of a run, in whole vectors
inline constexpr int kPatchRun = kRun + 2 * kPatchPad;
static_assert(kPatchRadius <= kPatchPad && kPatchPad <= kPad);

// Returns exp(-x) for x >= 0 with an error of at most 1e-5, and 0 for x >= 87. The function has no
// branches, so it vectorises. std::exp() does not vectorise in code that must preserve NaN.
inline float exp_minus(float x) {
  const float t = std::min(x, 87.0f) * -1.44269504f;  // in powers of two
  const int whole = int(t) - 1;                       // at most t, since t <= 0
  const float f = t - float(whole);                   // (0, 1]
  // A least-squares polynomial for 2^f.
  float p = 0.0018775767f;
  p = p * f + 0.0089893397f;
  p = p * f + 0.0558263180f;
  p = p * f + 0.2401536100f;
  p = p * f + 0.6931530700f;
  p = p * f + 0.9999999400f;
  const float scale = std::bit_cast<float>((whole + 127) << 23);
  return x < 87.0f ? p * scale : 0.0f;
}

// A run is kRun neighbouring pixels of a row. For each pixel of the run, in each of the kTileRows
// rows from y0 on, writes to `means` the mean distance over the patch around the pixel. distance(y,
// out) must write the kPatchRun per-pixel distances of row y, beginning kPatchPad columns to the
// left of the run.
template <int Radius, typename Distance>
void patch_means(int y0, const Distance& distance, float (*means)[kRun]) {
  float single[kTileRows + 2 * Radius][kPatchRun];
  for (int r = 0; r < kTileRows + 2 * Radius; ++r) distance(y0 + r - Radius, single[r]);
  constexpr float kInverseArea = 1.0f / float((2 * Radius + 1) * (2 * Radius + 1));
  for (int r = 0; r < kTileRows; ++r) {
    float column[kPatchRun];
    for (int x = 0; x < kPatchRun; ++x) column[x] = single[r][x];
    for (int j = 1; j <= 2 * Radius; ++j) {
      for (int x = 0; x < kPatchRun; ++x) column[x] += single[r + j][x];
    }
    for (int x = 0; x < kRun; ++x) {
      float sum = 0.0f;
      for (int i = -Radius; i <= Radius; ++i) sum += column[kPatchPad + x + i];
      means[r][x] = sum * kInverseArea;
    }
  }
}

}  // namespace emberline
