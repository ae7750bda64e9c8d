// Averages a frame's halves with those of neighbouring frames, which reduces the noise before any
// filter.
#pragma once

#include <span>
#include <vector>

#include "renderer/reconstruction/halves.h"

namespace emberline {

// The mean over frames, as an input for prepare_halves(). A neighbour's pixel counts as much as its
// samples, times the product of
//   - exp(-d), where d is the largest over all features of: the squared difference, less its noise,
//     over the squared tolerance or the noise, whichever is larger: another surface came into view;
//   - 1 / (1 + d) for a small and 1 / (1 + d)^2 for a large neighbourhood, where d is the squared
//     difference of the colours, less their noise, over the noise: edges do not meet, or the light
//     has changed. 1 / (1 + d) is about the optimal weight of a value with a bias.
// The weights of one half come from the colours of the other half.
class AccumulatedFrames {
 public:
  // `halves` are those of `frame`, without features. Both must outlive the constructor only.
  AccumulatedFrames(const DenoiseInput& frame, const Halves& halves,
                    std::span<const NeighbourFrame> neighbours);

  // Views of this object's planes. Light groups are included, without the excess of outliers.
  const DenoiseInput& input() const { return input_; }
  // Returns how many frames a pixel combines (the sum of their weights, 1 for the frame itself),
  // summed over the pixels of rows [begin, end).
  double frames(int begin, int end) const;

 private:
  std::vector<std::vector<float>> planes_;
  DenoiseInput input_;
  std::vector<float> frames_;
};

// An accumulated pixel depends on pixels of the frame up to this far away.
inline constexpr int kAccumulateReach = 10;

}  // namespace emberline
