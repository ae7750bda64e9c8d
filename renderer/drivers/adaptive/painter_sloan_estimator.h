// `painter-sloan`: the confidence test of Painter & Sloan 1989, "Antialiased Ray Tracing by
// Adaptive Progressive Refinement", Computer Graphics 23(3) (SIGGRAPH 89), at pixel level. The
// paper's tree above the pixel level is part of the driver (refinement_tree.h). Inside a pixel all
// samples have equal weights, so the paper's area weights are not needed.
//
// The error is half the width of the 95 % confidence interval of the pixel's mean in display units,
// t_.975(n - 1) sqrt(variance / n), as the root mean square over the channels. This is 2.4 times
// the expected RMS error at 8 samples, and about twice that error if there are many samples. The
// test assumes independent samples, so the interval is too wide for stratified ones.
//
// With 2 to 7 samples, the interval is unreliable. The error is then at least the standard
// deviation of the displayed means of the pixel and its four edge neighbours (the paper's external
// variance). Neighbours without samples are left out. With fewer than 2 samples, the pixel is
// unfinished.
//
// Known fault of the method: a pixel is judged only by its own samples, so rare light is lost, as
// with `chi-square`. For example, the interval of eight black samples has zero width.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// Such tests usually begin with 4 to 8 samples; 8 is the upper end. The batch size is our choice.
inline constexpr uint32_t kPainterSloanBatch = 8;

void estimate_painter_sloan(const PixelStatistics& pixels, const EstimatorSettings& settings,
                            ErrorMap* out);

}  // namespace emberline
