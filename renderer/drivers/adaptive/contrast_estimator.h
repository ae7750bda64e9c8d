// `contrast`: the test of Mitchell 1987, "Generating Antialiased Images at Low Sampling Densities",
// Computer Graphics 21(4) (SIGGRAPH 87). Pixels get more samples where neighbouring pixels differ
// visibly.
//
// The contrast of a channel is (max - min) / (max + min) over a pixel and its eight neighbours, in
// linear light clipped to [0, 1] as on a display. It is 0 if all these pixels are black. The paper
// compares single samples. Path-traced samples differ even where the picture is flat, because of
// noise, so this estimator compares means. The paper's limits are .4 for red, .3 for green and .6
// for blue. The error is the largest of the three ratios of contrast to limit, times
// kContrastThreshold; it is not an RMS error. So --noise-threshold .02 is the paper's rule, and .01
// halves the paper's limits. The error is at most .0667, the value for a black pixel next to a
// green one.
//
// Known faults of the method: contrast is not noise. A clean edge stays unfinished up to --max-spp,
// noise counts only if it makes neighbours differ, and in the dark all noise has full contrast.
// Small features are not found if all samples of a neighbourhood have missed them.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// A --noise-threshold of this value means the paper's limits. The value is our choice, so that a
// threshold means about the same for all estimators: .005 (one level of 255) is invisible, and .08
// is obvious.
inline constexpr float kContrastThreshold = 0.02f;
inline constexpr uint32_t kContrastBatch =
    8;  // our choice: with fewer samples, path-traced pixels are too noisy

void estimate_contrast(const PixelStatistics& pixels, const EstimatorSettings& settings,
                       ErrorMap* out);

}  // namespace emberline
