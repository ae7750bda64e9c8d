// Averages a frame's halves with those of neighbouring frames, which reduces the noise before any
// filter.
#pragma once

#include <span>
#include <vector>

#include "renderer/reconstruction/halves.h"

namespace emberline {

// The mean over frames, as an input for prepare_halves(). A neighbouring frame's pixel is weighted
// by its number of samples, multiplied by
//   - exp(-d), which detects that another surface has come into view. Each feature's squared
//     difference, less its noise, is divided by the squared tolerance or by the noise, whichever is
//     larger. d is the largest of these values.
//   - 1 / (1 + d) for a small and 1 / (1 + d)^2 for a large neighbourhood, which detect misaligned
//     edges and changed light. d is the squared difference of the colours, less their noise,
//     divided by the noise. 1 / (1 + d) is about the optimal weight of a value with a bias.
// The weights of one half come from the colours of the other half.
class AccumulatedFrames {
 public:
  // `halves` are those of `frame`, without features. Both are used only during construction.
  AccumulatedFrames(const DenoiseInput& frame, const Halves& halves,
                    std::span<const NeighbourFrame> neighbours);

  // Views of this object's planes. Light groups are included, without the excess light of outliers
  // (Halves::excess).
  const DenoiseInput& input() const { return input_; }
  // Returns the number of frames that a pixel combines, summed over the pixels of rows [begin,
  // end). A neighbouring frame counts by its weight, and the frame itself counts as 1.
  double frames(int begin, int end) const;

 private:
  std::vector<std::vector<float>> planes_;
  DenoiseInput input_;
  std::vector<float> frames_;
};

// An accumulated pixel depends on pixels of the frame up to this far away.
inline constexpr int kAccumulateReach = 10;

}  // namespace emberline
