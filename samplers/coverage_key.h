// The random number that decides whether a ray hits a surface with stochastic coverage.
//
// The decisions are stratified over the samples of a pixel, separately for each surface (Laine &
// Karras 2011, "Stratified Sampling for Stochastic Transparency", EGSR): of 64 samples, 16 hit a
// surface of coverage 1/4, not 16 +- 3.5. The decisions for different surfaces are independent, so
// two surfaces transmit the product of their transmittances. A decision depends only on the key and
// the surface, not on the order in which a ray's hits are found.
#pragma once

#include <cstdint>

#include "renderer/core/hash.h"
#include "samplers/owen_sobol.h"

namespace emberline {

// Each ray has a key, which is passed by value in one register. The default key means that there is
// no stochastic coverage.
struct CoverageKey {
  uint32_t seed = 0;   // shared by samples that are stratified together
  uint32_t index = 0;  // the sample's index among those samples
};

// Two numbers in [0, 1) per triangle: the first decides coverage, the second chooses a texel.
struct CoverageNumbers {
  CoverageNumbers(CoverageKey key, uint32_t instance, uint32_t primitive)
      : seed_(hash_combine(hash_combine(key.seed, instance), primitive)), index_(key.index) {}

  float decision() const {
    const uint32_t index = owen_sobol::shuffle_in_blocks(index_, seed_);
    return owen_sobol::reversed_to_unit_float(owen_sobol::permute(index, hash32(~seed_)));
  }
  float texel() const { return to_unit_float(hash_combine(seed_, index_)); }

 private:
  uint32_t seed_, index_;
};

}  // namespace emberline
