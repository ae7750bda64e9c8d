// Upper limit of the gain from sampling where the noise is. Neyman 1934, "On the Two Different
// Aspects of the Representative Method", J. R. Stat. Soc. 97(4): for a given cost, the sum of
// variances is smallest if pixel i gets samples in proportion to sqrt(v_i / c_i), with v the
// variance and c the cost of one sample of the pixel. Compared with equal numbers for all pixels,
// this costs
//
//   mean(v) mean(c) / mean(sqrt(v c))^2   (at least 1, by Cauchy and Schwarz)
//
// times less for the same error, or gives that much less error for the same cost.
//
// Stratified samples do better than independent ones. Where error falls as v_i / n^a, the best
// numbers are in proportion to (v_i / c_i)^(1 / (1 + a)), derived as Neyman's, and the cost of an
// error is
//
//   (mean(v) mean(c)^a / mean(v^(1 / (1 + a)) c^(a / (1 + a)))^(1 + a))^(1 / a)
//
// times less than with equal numbers for all pixels.
#pragma once

#include <span>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// The ratio of costs above; 1 if all variances or all costs are 0. Sizes are equal, values not
// negative; `slope` is the a above, > 0.
double neyman_limit(std::span<const double> variance, std::span<const double> cost,
                    double slope = 1.0);

// `variance` of one sample of each channel (3 per pixel), `seconds` per sample, `mean`: the
// picture. The variance of a pixel is the mean over channels of weight x variance. The weights are
// 1 for mse, 1 / (mean^2 + epsilon) for relmse, and for display the squared slope of the sRGB curve
// over mean +- 0.001, at least 0.02^2, since a sample has some value even in clipped white.
NeymanLimits neyman_limits(std::span<const float> variance, std::span<const float> seconds,
                           const RgbImage& mean, double epsilon);

}  // namespace emberline
