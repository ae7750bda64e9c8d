// `chi-square`: Lee, Redner & Uselton 1985, "Statistically Optimized Sampling for Distributed Ray
// Tracing", Computer Graphics 19(3) (SIGGRAPH 85).
//
// A pixel is finished when the variance of its mean is below T^2 with confidence 95 %: were the
// samples normal and independent, n s^2 / sigma^2 with s^2 = sum (x - mean)^2 / n would follow
// chi-square with n - 1 degrees of freedom, so sigma^2 / n < s^2 / chi2_.05(n - 1) in 19 cases of
// 20. The error is the root of that bound, in display units, root of the mean over the channels
// (the paper tests each channel): above the expected RMS error by 80 % at 8 samples, 17 % at 64.
//
// The paper takes 8 samples, then 8 for each test, and at most 96; here --max-spp is that cap.
// Below 8 the bound is too wide to be of use, and such a pixel is unfinished.
//
// Faults, kept: a pixel decides on its own samples alone, and stops the sooner the luckier they
// were. Eight equal samples have no variance, so light that fewer than one sample in twelve meet is
// more often lost than found, and the picture becomes too dark (Kirk & Arvo 1991, "Unbiased
// Sampling Techniques for Image Synthesis"): by 44 % where one sample in ten meets it, by 80 %
// where one in fifty does (tests/unit/error_estimator_statistics_test.cpp). Stratified samples,
// whose mean is better than their variance says, get more than they need.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

// The variance of the mean of `count` samples, 2 or more, is below this with confidence 95 %;
// `variance` is that of a sample (divided by n - 1), in any squared unit.
float chi_square_bound(float variance, float count);

class ChiSquareEstimator final : public ErrorEstimator {
 public:
  static constexpr uint32_t kFirstSamples = 8, kBatch = 8;
  explicit ChiSquareEstimator(const EstimatorSettings&) {}
  void estimate(const PixelStatistics& pixels, ErrorMetric allocation,
                ErrorMap* out) const override;
};

}  // namespace emberline
