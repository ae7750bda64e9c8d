// `nested`, the default: the variance of a pixel's mean as the two halves of one sample stream show
// it, pooled over the pixel's neighbours as `two-stream` does.
//
// Two streams of n/2 samples are an honest yardstick, but where stratification does much their mean
// is worse than that of one stream of n. One stream, taken in powers of two, has a yardstick of its
// own: every aligned block of a power of two of a scrambled Sobol' sequence is a net like any other
// (samplers/sobol_sampler.h), so that the halves' means M1, M2 have the same variance V(n/2) and,
// by symmetry, the same covariance with their mean M, V(n). Hence
//     E (M1 - M)^2 = E ((M1 - M2) / 2)^2 = V(n/2) - V(n):
// exactly what the last doubling has brought, which is what a planner wants to know of the next. It
// is V(n) itself where V ~ 1/n, and too large where stratification does better: 1.8 times for edges
// (V ~ n^-1.5), 3 times for V ~ n^-2. SampleHalves keeps what is needed. The planner has pixels go
// from power of two to power of two and, with less to judge by, half the way to the next.
//
// A correction by how the pixel's doublings have fallen so far (V ~ n^-a, a from the last two of
// the neighbours) was tried: the allocation gained nothing by it.
#pragma once

#include "renderer/drivers/adaptive/two_stream_estimator.h"

namespace emberline {

class NestedEstimator final : public ErrorEstimator {
 public:
  explicit NestedEstimator(const EstimatorSettings& settings) : pooled_(settings) {}
  // The statistics must hold halves (SampleHalves) in the place of streams.
  void estimate(const PixelStatistics& pixels, ErrorMetric allocation,
                ErrorMap* out) const override {
    pooled_.estimate(pixels, allocation, out);
  }

 private:
  TwoStreamEstimator pooled_;
};

}  // namespace emberline
