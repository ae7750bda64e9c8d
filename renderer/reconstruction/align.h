// Resamples a neighbouring frame's halves at the pixels of the denoised frame.
#pragma once

#include <vector>

#include "renderer/reconstruction/denoise.h"

namespace emberline {

// The input of a neighbouring frame, resampled at the denoised frame's pixels: each value is
// interpolated where the neighbouring frame shows the pixel's surface point. Interpolation is
// bicubic (R. Keys, "Cubic convolution interpolation for digital image processing", 1981), because
// a bilinear mean would blur edges. Outliers are limited first (renderer/reconstruction/halves.h).
// The result has no samples where the position is unknown or is next to pixels without samples.
class AlignedFrame {
 public:
  // `width` and `height` are those of the denoised frame's input.
  AlignedFrame(const NeighbourFrame& neighbour, int width, int height);

  // Views of this object's planes. If the neighbour has DenoiseInput::shared, `colour` is computed
  // from it.
  const DenoiseInput& input() const { return input_; }

 private:
  std::vector<std::vector<float>> planes_;
  DenoiseInput input_;
};

}  // namespace emberline
