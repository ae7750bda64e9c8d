#include "samplers/stratified_sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/core/constants.h"
#include "samplers/random_permutation.h"
#include "samplers/sample_runs.h"

namespace emberline {
namespace {

constexpr uint32_t kStratifiedSalt = 0x57a71f1eu;
constexpr int kPlanarDimensions = 4;  // the first two pairs

// The position has 28 bits, so that a double holds the sum of a cell index (24 bits) and this
// position exactly.
double position_in_cell(uint32_t bits) { return double(bits >> 4) * 0x1p-28; }
float clamp_below_one(double u) { return std::min(float(u), kOneMinusEpsilon); }

// One dimension's jitter for the samples of a run.
struct Jitter {
  uint32_t bits[kSampleLanes];

  Jitter(uint32_t key, const SampleRun& run) {
    for (int i = 0; i < run.count; ++i) {
      bits[i] = hash32(key ^ hash32(run.index + uint32_t(i) + 0x9e3779b9u));
    }
  }
};

void fill_plane(const JitterGrid& grid, const uint32_t* cell, const Jitter& jitter_x,
                const Jitter& jitter_y, int count, float* x, float* y) {
  const double per_cell = 1.0 / grid.cells;
  const double per_column = 1.0 / grid.columns, per_wide_column = 1.0 / (grid.columns + 1);
  for (int i = 0; i < count; ++i) {
    const bool wide = cell[i] < grid.wide_cells;
    const uint32_t columns = wide ? grid.columns + 1 : grid.columns;
    const double width = wide ? per_wide_column : per_column;
    const uint32_t index_in_rows = wide ? cell[i] : cell[i] - grid.wide_cells;
    // Adding half a cell keeps the quotient away from integers, so rounding cannot change the
    // result.
    const uint32_t column =
        index_in_rows - uint32_t(int32_t((index_in_rows + 0.5) * width)) * columns;
    x[i] = clamp_below_one((column + position_in_cell(jitter_x.bits[i])) * width);
    y[i] = clamp_below_one(((cell[i] - column) + columns * position_in_cell(jitter_y.bits[i])) *
                           per_cell);
  }
}

void fill_line(uint32_t cells, const uint32_t* cell, const Jitter& jitter, int count, float* x) {
  const double per_cell = 1.0 / cells;
  for (int i = 0; i < count; ++i) {
    x[i] = clamp_below_one((cell[i] + position_in_cell(jitter.bits[i])) * per_cell);
  }
}

}  // namespace

JitterGrid::JitterGrid(uint32_t cell_count) : cells(cell_count) {
  const auto rows = uint32_t(std::lround(std::sqrt(double(cells))));
  columns = cells / rows;
  wide_cells = cells % rows * (columns + 1);
}

StratifiedSampler::StratifiedSampler(const SamplerSettings& settings)
    : streams_(settings.streams),
      grids_{JitterGrid(std::max(1u, stream_length(streams_, 0, settings.samples_per_pixel))),
             JitterGrid(std::max(1u, stream_length(streams_, 1, settings.samples_per_pixel)))} {}

void StratifiedSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count,
                             SlotBlock& out, int dimensions) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  const uint32_t block_size[] = {grids_[0].cells, grids_[1].cells};
  for_each_run(streams_, block_size, first_sample, count, [&](const SampleRun& run) {
    const JitterGrid& grid = grids_[run.stream];
    const uint32_t slot_hash = hash_combine(run_hash(pixel, run, kStratifiedSalt), slot);
    for (int d = 0; d < dimensions;) {
      const RandomPermutation order(grid.cells, hash_combine(slot_hash, uint32_t(d)));
      uint32_t cell[kSampleLanes];
      order.places(run.index, run.count, cell);
      const Jitter jitter(hash_combine(slot_hash, 0x100u + uint32_t(d)), run);
      float* values = out.values[d] + run.lane;
      if (d < kPlanarDimensions) {
        const Jitter jitter_y(hash_combine(slot_hash, 0x101u + uint32_t(d)), run);
        fill_plane(grid, cell, jitter, jitter_y, run.count, values, values + kSampleLanes);
        d += 2;
      } else {
        fill_line(grid.cells, cell, jitter, run.count, values);
        d += 1;
      }
    }
  });
}

}  // namespace emberline
