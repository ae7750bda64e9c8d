// Jittered samples: the domain cut into as many equal cells as there are samples, one uniform point
// in each (Dippe & Wold 1985, "Antialiasing Through Stochastic Sampling", section 3.2; Cook, Porter
// & Carpenter 1984 for shuffled strata in further dimensions).
//
// The first two pairs of a slot are stratified in the plane, the four dimensions behind them, which
// the dimension plan uses one by one, each for itself. The plane is cut into about sqrt(n) rows
// whose heights are in proportion to the cells that they hold, so that any number n, a prime too,
// gives n cells of area 1/n. Worked: 7 samples are rows of 3, 2 and 2 cells, 3/7, 2/7, 2/7 high.
// Which sample gets which cell is an independent random order per dimension.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"

namespace emberline {

// A unit square in rows of cells of equal area.
struct JitterGrid {
  // cells: at least 1.
  explicit JitterGrid(uint32_t cells);
  uint32_t cells;
  uint32_t columns;     // of a row; the first rows have one more
  uint32_t wide_cells;  // how many cells are in those
};

class StratifiedSampler final : public Sampler {
 public:
  // With two streams each has cells of its own, as many as it gets of samples_per_pixel.
  explicit StratifiedSampler(const SamplerSettings& settings);
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }

 private:
  StreamCount streams_;
  JitterGrid grids_[2];  // one per stream
};

}  // namespace emberline
