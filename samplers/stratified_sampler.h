// Jittered samples: the domain is cut into as many equal cells as there are samples, and each cell
// gets one uniform point (Dippe & Wold 1985, "Antialiasing Through Stochastic Sampling", section
// 3.2; Cook, Porter & Carpenter 1984 for shuffled strata in further dimensions).
//
// The first two pairs of a slot are stratified in the plane. The other four dimensions are used one
// by one (sampler.h), so each is stratified separately. The plane is cut into about sqrt(n) rows.
// Each row's height is proportional to its number of cells, so that any n, even a prime, gives n
// cells of area 1/n. Example: 7 samples use rows of 3, 2 and 2 cells, with heights 3/7, 2/7 and
// 2/7. Each pair and each single dimension assigns cells to samples in an independent random order.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"

namespace emberline {

// The unit square cut into rows of cells of equal area.
struct JitterGrid {
  // cells: at least 1.
  explicit JitterGrid(uint32_t cells);
  uint32_t cells;
  uint32_t columns;     // cells per row; the first rows have one more cell
  uint32_t wide_cells;  // total number of cells in those first rows
};

class StratifiedSampler final : public Sampler {
 public:
  // With two streams, each stream has its own cells, as many as it has samples.
  explicit StratifiedSampler(const SamplerSettings& settings);
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }

 private:
  StreamCount streams_;
  JitterGrid grids_[2];  // one per stream
};

}  // namespace emberline
