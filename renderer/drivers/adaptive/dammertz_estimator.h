// `dammertz`: Dammertz, Hanika, Keller & Lensch 2009, "A Hierarchical Automatic Stopping Condition
// for Monte Carlo Global Illumination" (WSCG 2010).
//
// With I the mean of all of a pixel's samples and A that of its first stream (every second block of
// eight), a pixel's error is e_p = (|dR| + |dG| + |dB|) / sqrt(R + G + B), d = I - A, and that of a
// block b of the image e_b = sqrt(|b| / |image|) / |b| sum e_p. A block with e_b < eps is finished;
// one with e_b < 256 eps is split across its longer side where its error has its median, and its
// parts are judged alike; one above goes on whole. Every pixel has the error of its block. The
// blocks are found anew from each map: what was finished may take up again.
//
// Thresholds. For grey noise on a display curve like the square root, the mean of e_p is 2 sqrt(3)
// sqrt(2 / pi) = 2.76 times the standard error in display units. The error here is e_b over
// 2.76 sqrt(16 / |image|), so eps = 2.76 T sqrt(16 / |image|): --noise-threshold T asks for a
// standard error of about T of blocks of 16 pixels, where splitting ends, and for sqrt(16 / |b|) T
// of larger ones. Without a threshold blocks are split to the end, so that the map shows where the
// noise is.
//
// Faults, kept: above 256 T a crop is sampled evenly as a whole. A block's mean hides a few bad
// pixels among good ones. White beyond the display counts as if it were seen, and a black pixel,
// where no sample met light, as perfect.
#pragma once

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

inline constexpr uint32_t kDammertzBatch = 16;        // ours: a block of each stream
inline constexpr int kDammertzLeafPixels = 16;        // blocks of so many or fewer are not split
inline constexpr float kDammertzSplitLimit = 256.0f;  // times the threshold

void estimate_dammertz(const PixelStatistics& pixels, const EstimatorSettings& settings,
                       ErrorMap* out);

}  // namespace emberline
