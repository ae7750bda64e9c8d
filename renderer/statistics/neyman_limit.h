// Upper limit on the gain from giving more samples to noisier pixels. Neyman 1934, "On the Two
// Different Aspects of the Representative Method", J. R. Stat. Soc. 97(4): for a given cost, the
// sum of variances is smallest if pixel i gets samples in proportion to sqrt(v_i / c_i), where v is
// the variance and c the cost of one sample of the pixel. Compared with the same number of samples
// for every pixel, the cost at the same error, or the error at the same cost, is smaller by the
// factor
//
//   mean(v) mean(c) / mean(sqrt(v c))^2   (at least 1, by Cauchy and Schwarz)
//
// Stratified samples are better than independent ones. If the squared error of a pixel falls as v_i
// / n^a, the best numbers of samples are in proportion to (v_i / c_i)^(1 / (1 + a)), which is
// derived as in Neyman's paper. The cost at the same error is then smaller by the factor
//
//   (mean(v) mean(c)^a / mean(v^(1 / (1 + a)) c^(a / (1 + a)))^(1 + a))^(1 / a)
#pragma once

#include <span>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Returns the factor above; 1 if all variances or all costs are 0. Both lists must have the same
// size and no negative value. `slope` is the a above, which must be > 0.
double neyman_limit(std::span<const double> variance, std::span<const double> cost,
                    double slope = 1.0);

// `variance` has the variance of one sample for each channel (3 per pixel); `seconds` has the time
// per sample for each pixel; `mean` is the picture. A pixel's variance in a metric is the mean over
// channels of weight x variance. The weights are 1 for mse, 1 / (mean^2 + epsilon) for relmse, and
// for display the squared slope of the sRGB curve over mean +- 0.001. The latter is at least
// 0.02^2, since a sample has some value even in clipped white.
NeymanLimits neyman_limits(std::span<const float> variance, std::span<const float> seconds,
                           const RgbImage& mean, double epsilon);

}  // namespace emberline
