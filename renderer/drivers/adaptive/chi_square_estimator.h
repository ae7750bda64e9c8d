// `chi-square`: Lee, Redner & Uselton 1985, "Statistically Optimized Sampling for Distributed Ray
// Tracing", Computer Graphics 19(3) (SIGGRAPH 85).
//
// A pixel is finished when the variance of its mean is below T^2 with confidence 95 %: of normal,
// independent samples n s^2 / sigma^2 with s^2 = sum (x - mean)^2 / n follows chi-square with n - 1
// degrees of freedom, so sigma^2 / n < s^2 / chi2_.05(n - 1) in 19 cases of 20. The error is the
// root of that bound, in display units, root of the mean over the channels (the paper tests each
// channel): above the expected RMS error by 80 % at 8 samples, 17 % at 64. A pixel with fewer than
// the first 8 samples is unfinished. The paper's most, 96 samples, is --max-spp here.
//
// Faults, kept: a pixel decides on its own samples alone, and stops the sooner the luckier they
// were, so that rare light is lost (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image
// Synthesis"; how much, tests/unit/drivers/adaptive/error_estimator_statistics_test.cpp).
// Stratified samples, whose mean is better than their variance says, get more than they need.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

inline constexpr uint32_t kChiSquareBatch = 8;  // the paper's: the first samples, and each test's

void estimate_chi_square(const PixelStatistics& pixels, const EstimatorSettings& settings,
                         ErrorMap* out);

}  // namespace emberline
