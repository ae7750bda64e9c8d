// Poisson-disk samples (Dippe & Wold 1985, "Antialiasing Through Stochastic Sampling", section
// 3.1): uniform points that keep a minimum distance from each other, so that aliases become
// high-frequency noise.
//
// Each prefix of the point sequence keeps the minimum distance that suits its length. Darts are
// thrown on the torus until one lands far enough from all earlier points; it becomes point n. The
// required distance is kPoissonDiskRadius times the largest minimum distance that n + 1 points can
// have (after McCool & Fiume 1992, "Hierarchical Poisson Disk Sampling Distributions", where radii
// shrink in steps). So a pixel may take any number of samples.
//
// Eight tables, each of 1024 such points, are built when the first sampler is created (22 ms). A
// pixel uses each table with a random shift on the torus and with one of the square's eight
// symmetries. The shift and the symmetry change every 1024 samples.
//
// The tables serve the pixel and lens pairs, and the BSDF and light pairs of the first three
// surfaces. Each pair of a pixel uses a different table, since pairs with the same table would be
// copies of each other. All other dimensions come from `sobol`. In particular, dimensions that are
// used one by one would gain nothing from points that keep their distance in the plane.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"
#include "samplers/sobol_sampler.h"

namespace emberline {

// The minimum distance, as a fraction of the largest minimum distance that n points can have, which
// is the neighbour distance in the hexagonal lattice. Random darts get stuck at 0.78. At 0.65, one
// dart in 47 is accepted.
inline constexpr double kPoissonDiskRadius = 0.65;

class PoissonDiskSampler final : public Sampler {
 public:
  // With two streams, each has separate shifts.
  explicit PoissonDiskSampler(const SamplerSettings& settings);
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }

 private:
  StreamCount streams_;
  SobolSampler fallback_;
};

}  // namespace emberline
