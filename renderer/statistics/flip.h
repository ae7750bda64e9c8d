// LDR-FLIP: the error that an observer sees when flipping between two pictures. Andersson, Nilsson,
// Akenine-Moller, Oskarsson, Astrom & Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
// Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2).
#pragma once

#include <vector>

#include "renderer/statistics/error_metrics.h"

namespace emberline {

// The paper's viewing conditions: the observer is 0.7 m from a display that is 0.7 m wide and has
// 3840 pixels per row.
constexpr double kFlipPixelsPerDegree = 67.0;

// Returns the error per pixel, in [0, 1], row-major. Both pictures must contain finite sRGB-encoded
// values in [0, 1] (see to_display), must have equal size and must not be empty (asserted).
// Swapping the two pictures does not change the result. Runs in parallel; the result is
// deterministic.
std::vector<float> flip_map(const RgbImage& picture, const RgbImage& reference,
                            double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace emberline
