// `dammertz`: Dammertz, Hanika, Keller & Lensch 2009, "A Hierarchical Automatic Stopping Condition
// for Monte Carlo Global Illumination" (WSCG 2010).
//
// Let I be the mean of all samples of a pixel, and A the mean of the pixel's first stream (every
// second block of eight samples). The pixel's error is e_p = (|dR| + |dG| + |dB|) / sqrt(R + G + B)
// with d = I - A, and the error of a block b of the image is e_b = sqrt(|b| / |image|) / |b| sum
// e_p. A block with e_b < eps is finished. A block with eps <= e_b < 256 eps is split across its
// longer side at the median of its error, and its two parts are tested in the same way. A block
// with a larger error is sampled as a whole. Each pixel has the error of its block. The blocks are
// computed anew for each map, so a finished pixel may become unfinished again.
//
// Thresholds: for grey noise, and a display curve like the square root, the mean of e_p is 2
// sqrt(3) sqrt(2 / pi) = 2.76 times the standard deviation of the pixel's mean in display units.
// The error map holds e_b / (2.76 sqrt(16 / |image|)), so a --noise-threshold of T means eps = 2.76
// T sqrt(16 / |image|). T thus demands a standard deviation of about T in the smallest blocks,
// which have 16 pixels, and of sqrt(16 / |b|) T in larger blocks. Without a threshold, blocks are
// split to the smallest size, so that the map shows where the noise is.
//
// Known faults of the method: a crop whose error is above 256 T is sampled evenly throughout. A
// block's mean hides a few bad pixels among good ones. Light brighter than the display's white
// counts as if it were visible, and a black pixel, where no sample found light, counts as perfect.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

inline constexpr uint32_t kDammertzBatch = 16;  // our choice: 8 samples of each stream
inline constexpr int kDammertzLeafPixels = 16;  // blocks of this size or smaller are not split
inline constexpr float kDammertzSplitLimit = 256.0f;  // times the threshold

void estimate_dammertz(const PixelStatistics& pixels, const EstimatorSettings& settings,
                       ErrorMap* out);

}  // namespace emberline
