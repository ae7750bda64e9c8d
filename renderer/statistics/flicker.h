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

// Returns the mean of ((x' - r')(q) - (x - r)(p))^2 / (r(p)^2 + epsilon) over all pixels p and
// channels, without the worst 0.1 % of the pixels, where x' and r' belong to the next frame and q
// is the pixel to which p moves. `epsilon` is that of the frame's relMSE. If the errors of both
// frames are independent, this is the sum of their relMSE; if they stick to things, it is 0.
//
// Skips pixels with a NaN or infinity, pixels that leave the picture, and those that something
// else covers in the next frame: whose motion differs by more than a pixel from that at q. Returns
// NaN if no pixel remains. Runs in parallel; the bits do not depend on the number of threads.
double flicker(const SequenceFrame& frame, const SequenceFrame& next, double epsilon);

}  // namespace emberline
