// The number of samples of each pixel of a frame, decided before the frame begins. Crops, tiles and
// parts of the frame therefore get the same counts as the whole frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

struct SamplePlan {
  Rect crop;                     // the planned pixels of the frame
  std::vector<uint32_t> counts;  // rows from the crop's top; at least 1

  uint32_t count(int x, int y) const { return counts[crop.index_of(x, y)]; }
};

}  // namespace emberline
