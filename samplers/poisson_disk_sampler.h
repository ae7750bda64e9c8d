// Poisson-disk samples (Dippe & Wold 1985, "Antialiasing Through Stochastic Sampling",
// section 3.1): uniform points of which no two are close, so that aliases become noise of high
// frequency.
//
// The points are a sequence, each prefix of which keeps its distance: point n is a dart thrown
// until it is at least kPoissonDiskRadius of the largest possible distance of n + 1 points away
// from all before it, on the torus (after McCool & Fiume 1992, "Hierarchical Poisson Disk Sampling
// Distributions", where radii shrink in steps). So a pixel may take any number of samples. Eight
// such tables of 1024 points are made when the first sampler is (22 ms); a pixel takes each at a
// random shift of the torus and in one of its eight symmetries, both afresh after 1024 samples.
//
// Pixel and lens, and the BSDF and light pairs of the first three surfaces, have a table each, a
// different one for each pair of a pixel: pairs with the same table would be copies of one another.
// All other dimensions, single ones above all, of which a disk in the plane stratifies nothing, are
// those of `sobol`.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"
#include "samplers/sobol_sampler.h"

namespace emberline {

// Of the distance between neighbours in the hexagonal lattice, the largest that n points can keep.
// Darts at random get stuck at 0.78; here one in 47 hits.
inline constexpr double kPoissonDiskRadius = 0.65;

class PoissonDiskSampler final : public Sampler {
 public:
  // With two streams, each has shifts of its own.
  explicit PoissonDiskSampler(const SamplerSettings& settings);
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }

 private:
  StreamCount streams_;
  SobolSampler rest_;
};

}  // namespace emberline
