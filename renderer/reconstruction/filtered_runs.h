// The regression over all pixels of some rows, tile by tile.
#pragma once

#include <span>
#include <stop_token>
#include <vector>

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

// sink(picture, run) for all pixels of rows [begin, end), each bandwidth and each picture, from
// many threads at once; those of a pixel come from one thread. The fit is made once for all
// pictures.
template <typename Sink>
class RunFilter {
 public:
  RunFilter(const Halves& halves, std::span<const HalfPictures> pictures, const Sink& sink)
      : halves_(halves), pictures_(pictures), sink_(sink) {}

  void filter(const Tile& tile) const {
    WindowWeights weights;
    weights.measure(halves_, tile);
    PixelFilter filter(halves_);
    std::vector<FilteredRun> runs(pictures_.size());
    for (int row = 0; row < tile.rows; ++row) {
      for (int column = 0; column < tile.columns; column += kLanes) {
        for (size_t k = 0; k < kBandwidths; ++k) {
          for (FilteredRun& run : runs) {
            run = {};
            run.x = tile.x + column;
            run.y = tile.y + row;
            run.columns = std::min(kLanes, tile.columns - column);
            run.bandwidth = k;
          }
          for (size_t s = 0; s < 2; ++s) {
            filter.fit(weights, s, int(k), tile, column, row);
            for (size_t p = 0; p < runs.size(); ++p) add_half(filter, s, pictures_[p], runs[p]);
          }
          for (size_t p = 0; p < runs.size(); ++p) sink_(p, runs[p]);
        }
      }
    }
  }

 private:
  void add_half(const PixelFilter& filter, size_t s, const HalfPictures& pictures,
                FilteredRun& run) const {
    float colour[3][kLanes], own_weight[kLanes];
    filter.apply(pictures[s], colour);
    filter.own_weight(own_weight);
    const float* share = halves_.share[s].row(run.y) + run.x;
    const float sign = s == 0 ? 1.0f : -1.0f;
    for (int x = 0; x < kLanes; ++x) {
      for (size_t c = 0; c < 3; ++c) {
        run.colour[c][x] += share[x] * colour[c][x];
        run.difference[c][x] += sign * colour[c][x];
      }
      run.own_weight[x] += share[x] * own_weight[x];
    }
  }

  const Halves& halves_;
  std::span<const HalfPictures> pictures_;
  const Sink& sink_;
};

template <typename Sink>
void filter_runs(const Halves& halves, int begin, int end, std::span<const HalfPictures> pictures,
                 const std::stop_token& stop, const Sink& sink) {
  const RunFilter filter(halves, pictures, sink);
  for_each_tile(halves.width, begin, end, [&](const Tile& tile) {
    if (!stop.stop_requested()) filter.filter(tile);
  });
}

}  // namespace emberline
