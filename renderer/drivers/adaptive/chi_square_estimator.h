// `chi-square`: the test of Lee, Redner & Uselton 1985, "Statistically Optimized Sampling for
// Distributed Ray Tracing", Computer Graphics 19(3) (SIGGRAPH 85).
//
// A pixel is finished when the variance of its mean is below T^2 with 95 % confidence. Let s^2 be
// sum (x - mean)^2 / n. For normal, independent samples, n s^2 / sigma^2 has a chi-square
// distribution with n - 1 degrees of freedom, so sigma^2 / n < s^2 / chi2_.05(n - 1) with
// probability .95. The error is the square root of that bound in display units, as the root mean
// square over the channels (the paper tests each channel). This error exceeds the expected RMS
// error by 80 % at 8 samples and by 17 % at 64 samples. A pixel with fewer than 8 samples is
// unfinished. The paper's maximum of 96 samples is --max-spp here.
//
// Known faults of the method: a pixel is judged only by its own samples and stops early if these
// happen to agree, so rare light is lost (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image
// Synthesis"; measured in tests/unit/drivers/adaptive/error_estimator_statistics_test.cpp). The
// mean of stratified samples is more accurate than their variance suggests, so pixels with such
// samples get more samples than they need.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

inline constexpr uint32_t kChiSquareBatch =
    8;  // from the paper: 8 samples before the first test, and 8 more before each further test

void estimate_chi_square(const PixelStatistics& pixels, const EstimatorSettings& settings,
                         ErrorMap* out);

}  // namespace emberline
