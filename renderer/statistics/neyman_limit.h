// How much sampling where the noise is can gain at most. Neyman 1934, "On the Two Different Aspects
// of the Representative Method", J. R. Stat. Soc. 97(4): for a given cost the sum of variances is
// least when pixel i gets samples in proportion to sqrt(v_i / c_i), with v its variance of one
// sample and c the cost of one. Against the same number for every pixel that is
//
//   mean(v) mean(c) / mean(sqrt(v c))^2   (at least 1, by Cauchy and Schwarz)
//
// times less cost for the same error, or as much less error for the same cost.
//
// Stratified samples do better than independent ones: where error falls as v_i / n^a, the best
// numbers are in proportion to (v_i / c_i)^(1 / (1 + a)), found as Neyman's are, and the cost of an
// error is
//
//   (mean(v) mean(c)^a / mean(v^(1 / (1 + a)) c^(a / (1 + a)))^(1 + a))^(1 / a)
//
// times less than with the same number for every pixel.
#pragma once

#include <span>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// The ratio of costs above; 1 where nothing varies or nothing costs. Sizes equal; values not
// negative; `slope`, the a above, is more than 0.
double neyman_limit(std::span<const double> variance, std::span<const double> cost,
                    double slope = 1.0);

// `variance` of one sample of each channel (3 a pixel), `seconds` one sample takes, `mean` the
// picture. The variance of a pixel is the mean over channels of weight x variance; the weights are
// 1 for mse, 1 / (mean^2 + epsilon) for relmse, and for display the squared slope of the sRGB curve
// over mean +- 0.001, at least 0.02^2: even in clipped white a sample is not worth nothing.
NeymanLimits neyman_limits(std::span<const float> variance, std::span<const float> seconds,
                           const RgbImage& mean, double epsilon);

}  // namespace emberline
