// Measures flicker: how much the error of a picture changes from one frame to the next, at points
// that move with the scene. Noise that is independent in each frame flickers. Noise that moves with
// the objects does not.
#pragma once

#include <vector>

#include "renderer/statistics/error_metrics.h"

namespace emberline {

// The motion of each pixel from this frame to the next, in pixels to the right and down, row by
// row. The lists are empty if nothing moves.
struct PixelMotion {
  std::vector<float> right, down;

  bool empty() const { return right.empty(); }
};

// One frame of a sequence. All pictures have the same size (asserted).
struct SequenceFrame {
  const RgbImage& image;
  const RgbImage& reference;
  const PixelMotion& motion;
};

struct Flicker {
  double value = ErrorMetrics::kNone;  // NaN if no pixel was measured
  double share = 0;                    // fraction of the pixels that were measured
};

// Returns the mean of (e'(q) - e(p))^2 over all pixels p and channels, without the worst 0.1 % of
// the pixels. Here e = (x - r) / sqrt(r^2 + epsilon) is the relative error of a channel, so e^2 is
// its squared error in relMSE; e' is the relative error in the next frame; q is the pixel to which
// p moves. If the errors of the two frames are independent, the result is about the sum of the
// trimmed relMSE of both. If the errors move with the objects, it is near 0.
//
// Skips a pixel p if it has a NaN or infinity, if it leaves the picture, or if another object
// covers it in the next frame. p counts as covered if its motion differs from the motion at q by
// more than a pixel and by more than a quarter of p's motion. Runs in parallel; the result is
// bit-identical for any number of threads.
Flicker flicker(const SequenceFrame& frame, const SequenceFrame& next, double epsilon);

}  // namespace emberline
