// The number that decides whether a surface with stochastic coverage is there for one ray.
//
// Such decisions are stratified over the samples of a pixel, surface by surface (Laine & Karras
// 2011, "Stratified Sampling for Stochastic Transparency", EGSR): a pane of coverage 1/4 is there
// for 16 of 64 samples, not for 16 +- 3.5. Surfaces are independent of each other, so that two
// panes let the product of what each lets pass through; and a decision depends on nothing but key
// and surface, whatever order a ray's hits are found in.
#pragma once

#include <cstdint>

#include "renderer/core/hash.h"
#include "samplers/owen_sobol.h"

namespace emberline {

// One per ray; passed by value, in one register. Default: of scenes where nothing asks.
struct CoverageKey {
  uint32_t seed = 0;   // what the samples have in common that are stratified together
  uint32_t index = 0;  // which of them this is
};

// Two numbers in [0, 1) of one triangle: the first decides, the second chooses a texel.
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
