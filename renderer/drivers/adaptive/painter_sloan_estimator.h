// `painter-sloan`: the confidence test of Painter & Sloan 1989, "Antialiased Ray Tracing by
// Adaptive Progressive Refinement", Computer Graphics 23(3) (SIGGRAPH 89), at pixel level. The
// paper's tree above the pixel level belongs to the driver; inside a pixel all samples weigh the
// same, so its area weights have nothing to do here.
//
// The error is half the width of the 95 % confidence interval of the pixel's mean in display units,
// t_.975(n - 1) sqrt(variance / n), root of the mean over the channels: not the expected RMS error
// but 2.4 times it at 8 samples and twice it for many. It takes samples for independent, so for
// stratified ones the interval is too wide.
//
// From 2 samples to 7 the interval says little, and the larger of it and the deviation of the
// neighbourhood counts: of the displayed means of the pixel and of those of its four edge
// neighbours that have samples (the paper's external variance). Below 2 the pixel is unfinished.
//
// Fault, kept: a pixel stops on its own samples, so that rare light is lost, as with `chi-square`;
// eight black samples have an interval of no width.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// The upper end of the 4 to 8 samples that such tests usually begin with; the batch is ours.
inline constexpr uint32_t kPainterSloanBatch = 8;

void estimate_painter_sloan(const PixelStatistics& pixels, const EstimatorSettings& settings,
                            ErrorMap* out);

}  // namespace emberline
