// The regression over all pixels of some rows, tile by tile.
#pragma once

#include <stop_token>

#include "renderer/reconstruction/regression.h"

namespace emberline {

// The filtered values of a few pixels of a row: the mean of both halves, by their counts.
struct FilteredRun {
  int x, y, columns;
  size_t bandwidth;
  float colour[3][kLanes];
  float difference[3][kLanes];  // of the filtered halves
  float own_weight[kLanes];     // of a pixel in its own value
};

// Of either half.
using HalfPictures = std::array<PixelFilter::Picture, 2>;

inline FilteredRun filtered_run(const Halves& halves, const WindowWeights& weights,
                                const Tile& tile, int column, int row, size_t bandwidth,
                                const HalfPictures& pictures, PixelFilter& filter) {
  FilteredRun run = {};
  run.x = tile.x + column;
  run.y = tile.y + row;
  run.columns = std::min(kLanes, tile.columns - column);
  run.bandwidth = bandwidth;
  for (size_t s = 0; s < 2; ++s) {
    float colour[3][kLanes], own_weight[kLanes];
    filter.fit(weights, s, int(bandwidth), tile, column, row);
    filter.apply(pictures[s], colour);
    filter.own_weight(own_weight);
    const float* share = halves.share[s].row(run.y) + run.x;
    const float sign = s == 0 ? 1.0f : -1.0f;
    for (int x = 0; x < kLanes; ++x) {
      for (size_t c = 0; c < 3; ++c) {
        run.colour[c][x] += share[x] * colour[c][x];
        run.difference[c][x] += sign * colour[c][x];
      }
      run.own_weight[x] += share[x] * own_weight[x];
    }
  }
  return run;
}

// sink(run) for all pixels of rows [begin, end) and each bandwidth, from many threads at once;
// those of a pixel come from one thread.
template <typename Sink>
void filter_runs(const Halves& halves, int begin, int end, const HalfPictures& pictures,
                 const std::stop_token& stop, const Sink& sink) {
  for_each_tile(halves.width, begin, end, [&](const Tile& tile) {
    if (stop.stop_requested()) return;
    WindowWeights weights;
    weights.measure(halves, tile);
    PixelFilter filter(halves);
    for (int row = 0; row < tile.rows; ++row) {
      for (int column = 0; column < tile.columns; column += kLanes) {
        for (size_t k = 0; k < kBandwidths; ++k) {
          sink(filtered_run(halves, weights, tile, column, row, k, pictures, filter));
        }
      }
    }
  });
}

}  // namespace emberline
