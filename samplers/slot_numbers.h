// Access to a slot's numbers sample by sample, for statistics and tests.
#pragma once

#include "samplers/sampler.h"

namespace emberline {

struct SlotNumbers {
  float u[kSlotDimensions];
};

// Calls visit(sample index, numbers) for samples 0 .. count - 1. Reads them in batches of 16.
template <typename Visit>
void for_each_sample(const Sampler& sampler, const PixelKey& pixel, uint32_t slot, uint32_t count,
                     Visit&& visit) {
  SlotBlock block;
  for (uint32_t first = 0; first < count; first += kSampleLanes) {
    sampler.fill(pixel, slot, first, kSampleLanes, block);
    for (uint32_t lane = 0; lane < kSampleLanes && first + lane < count; ++lane) {
      SlotNumbers numbers;
      for (int d = 0; d < kSlotDimensions; ++d) numbers.u[d] = block.values[d][lane];
      visit(first + lane, numbers);
    }
  }
}

}  // namespace emberline
