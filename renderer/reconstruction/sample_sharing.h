// A pixel's value from its own samples and those of the eight pixels around it whose filters
// overlap its own: the same expectation, and about half the variance with the default filter. At
// edges and in texture, where a filter finds no pixels of the same kind, this is most of what it
// can do.
#pragma once

#include <array>
#include <vector>

#include "renderer/reconstruction/denoise.h"

namespace emberline {

inline constexpr int kSharingReach = 1;

class SharedColour {
 public:
  // Of `input.colour` where nothing is shared: at the border, and where a neighbour has fewer than
  // half as many samples. Does nothing for an input without `shared` or with parts.
  explicit SharedColour(const DenoiseInput& input);

  bool empty() const { return planes_[0][0].empty(); }
  HalfColour colour() const;

 private:
  std::array<std::array<std::vector<float>, 2>, 3> planes_;  // [channel][half]
};

}  // namespace emberline
