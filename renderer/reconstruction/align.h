// Brings a neighbouring frame's halves to the pixels of a frame.
#pragma once

#include <vector>

#include "renderer/reconstruction/denoise.h"

namespace emberline {

// The input of a neighbouring frame as if it had been rendered at the frame's pixels: each value is
// interpolated where the pixel is in the neighbouring frame (bicubic, R. Keys, "Cubic convolution
// interpolation for digital image processing", 1981; a bilinear mean would blur edges). Outliers
// are limited before (renderer/reconstruction/halves.h). A pixel without a position, or next to
// pixels without samples, has no samples.
class AlignedFrame {
 public:
  // `width` and `height` are those of the frame's input.
  AlignedFrame(const NeighbourFrame& neighbour, int width, int height);

  // Views of this object's planes. If the neighbour has shared samples, `colour` is made of these.
  const DenoiseInput& input() const { return input_; }

 private:
  std::vector<std::vector<float>> planes_;
  DenoiseInput input_;
};

}  // namespace emberline
