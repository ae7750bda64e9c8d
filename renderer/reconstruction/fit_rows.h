// The fits of all windows that reach some rows, tile by tile.
#pragma once

#include <stop_token>

#include "renderer/reconstruction/regression.h"

namespace emberline {

// Whether there is noise in a run of pixels; if not, a fit has nothing to say of its window that
// its noisy pixels' own do not.
inline bool has_noise(const Halves& halves, int x, int y) {
  for (const Half& half : halves.half) {
    const float* noise = half.noise.row(y) + x;
    for (int i = 0; i < kLanes; ++i) {
      if (noise[i] > 0.0f) return true;
    }
  }
  return false;
}

// body(fit, half, bandwidth) for each fit that says something of rows [begin, end), from many
// threads at once, but never for two that say something of the same pixel, and of a pixel always in
// the same order.
template <typename Body>
void for_each_fit(const Halves& halves, Place place, int begin, int end,
                  const std::stop_token& stop, const Body& body) {
  begin = std::max(begin - kWindowRadius, 0);
  end = std::min(end + kWindowRadius, halves.height);
  for_each_tile_apart(halves.width, begin, end, place, [&](const Tile& tile) {
    if (stop.stop_requested()) return;
    WindowWeights weights;
    bool measured = false;
    WindowFit fit(halves);
    for (int row = std::max(begin - tile.y, 0); row < std::min(end - tile.y, tile.rows); ++row) {
      for (int column = 0; column < tile.columns; column += kLanes) {
        if (!has_noise(halves, tile.x + column, tile.y + row)) continue;
        if (!measured) weights.measure(halves, tile);
        measured = true;
        fit.set_place(tile, column, row);
        for (int k = 0; k < kBandwidths; ++k) {
          for (size_t s = 0; s < 2; ++s) {
            fit.fit(weights, s, k);
            body(fit, s, size_t(k));
          }
        }
      }
    }
  });
}

}  // namespace emberline
