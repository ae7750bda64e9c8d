// Computes an upper limit on the gain from giving more samples to noisier pixels. Neyman 1934, "On
// the Two Different Aspects of the Representative Method", J. R. Stat. Soc. 97(4), shows: for a
// given cost, the sum of variances is smallest if pixel i gets samples in proportion to sqrt(v_i /
// c_i), where v_i is the variance and c_i the cost of one sample of the pixel. Compared with the
// same number of samples for every pixel, the cost at the same error (or the squared error at the
// same cost) is smaller by the factor
//
//   mean(v) mean(c) / mean(sqrt(v c))^2   (at least 1, by Cauchy and Schwarz)
//
// Stratified samples are better than independent samples. Suppose that the squared error of a pixel
// after n samples is v_i / n^a. Then the best numbers of samples are in proportion to (v_i /
// c_i)^(1 / (1 + a)), which is derived as in Neyman's paper. The cost at the same error is smaller
// by the factor
//
//   (mean(v) mean(c)^a / mean(v^(1 / (1 + a)) c^(a / (1 + a)))^(1 + a))^(1 / a)
#pragma once

#include <span>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Returns the second factor above, with a = `slope` (> 0). If all variances or all costs are 0,
// returns 1. Both lists must have the same size and no negative values.
double neyman_limit(std::span<const double> variance, std::span<const double> cost,
                    double slope = 1.0);

// `variance` has the variance of one sample for each channel (3 per pixel). `seconds` has the time
// per sample for each pixel. `mean` is the picture. A pixel's variance in a metric is the mean over
// channels of weight x variance. The weight is 1 for mse and 1 / (mean^2 + epsilon) for relmse. For
// display, it is the squared slope of the sRGB curve over mean +- 0.001, but at least 0.02^2, so
// that samples have some value even in clipped white.
NeymanLimits neyman_limits(std::span<const float> variance, std::span<const float> seconds,
                           const RgbImage& mean, double epsilon);

}  // namespace emberline
