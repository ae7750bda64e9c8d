// `contrast`: Mitchell 1987, "Generating Antialiased Images at Low Sampling Densities", Computer
// Graphics 21(4) (SIGGRAPH 87): more samples where neighbouring pixels differ more than the eye
// forgives.
//
// In each channel the contrast (max - min) / (max + min) of a pixel and its eight neighbours, in
// linear light clipped to [0, 1] as a display clips it; where all is black there is none. The paper
// compares samples; path traced ones differ by noise alone, so here means are compared.
// The paper's limits are .4 for red, .3 for green and .6 for blue. The error is the largest of the
// three contrasts over its limit, times kContrastThreshold: not an RMS error of any kind. So
// --noise-threshold .02 is the paper's rule, .01 halves its limits, and the error never exceeds
// .0667, where a black pixel meets a green one.
//
// Faults, kept: contrast is not noise. A clean edge stays unfinished up to --max-spp however many
// samples it has, noise counts only as far as it makes neighbours differ, and in the dark every
// noise has full contrast. Small features that all samples of a neighbourhood missed are not found.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// Ours: the threshold that stands for the paper's limits, in the middle of what is between
// invisible (.005, a level of 255) and glaring (.08), so that one --noise-threshold asks comparable
// things of all estimators.
inline constexpr float kContrastThreshold = 0.02f;
inline constexpr uint32_t kContrastBatch = 8;  // ours: path traced pixels are noisy with fewer

void estimate_contrast(const PixelStatistics& pixels, const EstimatorSettings& settings,
                       ErrorMap* out);

}  // namespace emberline
