// `painter-sloan`: the confidence test of Painter & Sloan 1989, "Antialiased Ray Tracing by
// Adaptive Progressive Refinement", Computer Graphics 23(3) (SIGGRAPH 89), at pixel level. The
// paper's tree above the pixel level belongs to the driver. Inside a pixel all samples have equal
// weights, so the paper's area weights are not needed.
//
// The error is half the width of the 95 % confidence interval of the pixel's mean in display units,
// t_.975(n - 1) sqrt(variance / n), root mean square over the channels: not the expected RMS error
// but 2.4 times it at 8 samples and twice it for many. It assumes independent samples, so the
// interval is too wide for stratified ones.
//
// From 2 to 7 samples the interval is unreliable, so the error is the larger of it and the
// deviation of the neighbourhood: of the displayed means of the pixel and of those of its four edge
// neighbours that have samples (the paper's external variance). Below 2 samples the pixel is
// unfinished.
//
// Known fault of the method: a pixel stops because of its own samples, so rare light is lost, as
// with `chi-square`. Eight black samples have an interval of zero width.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// The upper end of the 4 to 8 samples that such tests usually begin with; the batch size is our
// choice.
inline constexpr uint32_t kPainterSloanBatch = 8;

void estimate_painter_sloan(const PixelStatistics& pixels, const EstimatorSettings& settings,
                            ErrorMap* out);

}  // namespace emberline
