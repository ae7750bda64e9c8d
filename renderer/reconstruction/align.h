// Resamples a neighbouring frame's halves at the pixels of a frame.
#pragma once

#include <vector>

#include "renderer/reconstruction/denoise.h"

namespace emberline {

// The input of a neighbouring frame, resampled at the frame's pixels: each value is interpolated at
// the pixel's position in the neighbouring frame. Interpolation is bicubic (R. Keys, "Cubic
// convolution interpolation for digital image processing", 1981), because a bilinear mean would
// blur edges. Outliers are limited first (renderer/reconstruction/halves.h). The result has no
// samples where the position is unknown or is next to pixels without samples.
class AlignedFrame {
 public:
  // `width` and `height` are those of the frame's input.
  AlignedFrame(const NeighbourFrame& neighbour, int width, int height);

  // Views of this object's planes. If the neighbour has shared samples, `colour` is computed from
  // them.
  const DenoiseInput& input() const { return input_; }

 private:
  std::vector<std::vector<float>> planes_;
  DenoiseInput input_;
};

}  // namespace emberline
