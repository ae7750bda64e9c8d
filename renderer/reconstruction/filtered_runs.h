// The regression over all pixels of some rows, tile by tile.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "renderer/reconstruction/regression.h"

namespace emberline {

// A run's filtered values: the mean of both halves, by their counts.
struct FilteredRun {
  int x, y, columns;
  int bandwidth;
  std::span<const std::array<float, kRun>> values;  // of each picture plane
  std::array<float, kRun> own_weight;               // of a pixel in its own value
};

// Planes of either half, in the same order.
using HalfPictures = std::array<std::vector<const Plane*>, 2>;

// sink(run) for each run of rows [begin, end) and each bandwidth, from many threads at once; a
// row's runs of one tile come from one thread.
template <typename Sink>
void filter_runs(const Halves& halves, int begin, int end, const HalfPictures& pictures,
                 const std::stop_token& stop, const Sink& sink) {
  const size_t planes = pictures[0].size();
  for_each_tile(halves.width, begin, end, [&](const Tile& tile) {
    if (stop.stop_requested()) return;
    WindowWeights weights;
    weights.measure(halves, tile);
    const auto filter = std::make_unique<RunFilter>(halves);
    std::vector<std::array<float, kRun>> values(planes), half_values(planes);
    for (int r = 0; r < tile.rows; ++r) {
      for (int bandwidth = 0; bandwidth < kBandwidths; ++bandwidth) {
        FilteredRun run{tile.x, tile.y + r, tile.columns, bandwidth, values, {}};
        for (auto& plane : values) plane.fill(0.0f);
        for (size_t s = 0; s < 2; ++s) {
          filter->fit(weights, s, bandwidth, tile, r);
          filter->apply(pictures[s], half_values.data());
          const float* share = halves.share[s].row(run.y) + run.x;
          for (size_t p = 0; p < planes; ++p) {
            for (size_t x = 0; x < kRun; ++x) values[p][x] += share[x] * half_values[p][x];
          }
          for (size_t x = 0; x < kRun; ++x) {
            run.own_weight[x] += share[x] * filter->own_weight()[x];
          }
        }
        sink(run);
      }
    }
  });
}

}  // namespace emberline
