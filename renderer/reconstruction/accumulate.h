// Averages a frame's halves with those of neighbouring frames, which reduces the noise before any
// filter.
#pragma once

#include <span>
#include <vector>

#include "renderer/reconstruction/halves.h"

namespace emberline {

// The mean over frames, as an input for prepare_halves(). A neighbour's pixel counts as much as its
// samples, times the product of
//   - exp(-d), where d is the squared difference of the features, less their noise, over the
//     squared tolerances: another surface came into view;
//   - 1 / (1 + k d) for two sizes of neighbourhoods, where d is the squared difference of the
//     colours, less their noise, over the noise: the light has changed, or edges do not meet. This
//     is about the optimal weight of a value with a bias.
// The weights of one half come from the colours of the other half.
class AccumulatedFrames {
 public:
  // `halves` are those of `frame`, without features. Both must outlive the constructor only.
  AccumulatedFrames(const DenoiseInput& frame, const Halves& halves,
                    std::span<const NeighbourFrame> neighbours);

  // Views of this object's planes. Light groups are included, without the excess of outliers.
  const DenoiseInput& input() const { return input_; }
  // Returns how many frames' samples the pixels combine, summed over rows [begin, end): between 1
  // and the number of frames for each pixel.
  double frames(int begin, int end) const;

 private:
  std::vector<std::vector<float>> planes_;
  DenoiseInput input_;
  std::vector<float> frames_;
};

// An accumulated pixel depends on pixels of the frame up to this far away.
inline constexpr int kAccumulateReach = 10;

}  // namespace emberline
