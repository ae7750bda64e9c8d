// Independent random numbers: a counter-based hash of (seed, pixel, sample, slot, dimension).
//
// This is plain Monte Carlo without stratification, hence without structured artefacts. It is the
// baseline for the other samplers, and a cross-check for reference images.
#pragma once

#include "samplers/sampler.h"

namespace emberline {

class IndependentSampler final : public Sampler {
 public:
  // All samples are independent, so any split into streams is valid. Therefore the settings are not
  // used.
  explicit IndependentSampler(const SamplerSettings&) {}
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return {sample, 0}; }
};

}  // namespace emberline
