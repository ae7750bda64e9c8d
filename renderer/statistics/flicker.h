// How much the error of a sequence changes from one frame to the next, at points that move with the
// scene. Noise that is independent in each frame flickers; noise that sticks to things does not.
#pragma once

#include <vector>

#include "renderer/statistics/error_metrics.h"

namespace emberline {

// Where each pixel moves until the next frame, in pixels to the right and down, row by row. Empty
// lists: nothing moves.
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
  double share = 0;                    // of the pixels that were measured
};

// Returns the mean of (e'(q) - e(p))^2 over all pixels p and channels, without the worst 0.1 % of
// the pixels. e = (x - r) / sqrt(r^2 + epsilon) is the relative error of a pixel, so that e^2 is
// that of relMSE; e' belongs to the next frame; q is the pixel to which p moves. If the errors of
// both frames are independent, this is about the sum of their trimmed relMSE; if they move with
// things, it is near 0.
//
// Skips pixels with a NaN or infinity, pixels that leave the picture, and those that something
// else covers in the next frame: whose motion differs from that at q by more than a pixel and more
// than a quarter. Runs in parallel; the bits do not depend on the number of threads.
Flicker flicker(const SequenceFrame& frame, const SequenceFrame& next, double epsilon);

}  // namespace emberline
