// Rectangles that a thread works on at a time: small enough for its caches.
#pragma once

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/patches.h"
#include "renderer/reconstruction/plane.h"

namespace emberline {

struct Tile {
  int x, y, columns, rows;  // at most kRun and kTileRows
};

// body(tile) for each tile of rows [begin, end), in parallel.
template <typename Body>
void for_each_tile(int width, int begin, int end, const Body& body) {
  const int across = (width + kRun - 1) / kRun, down = (end - begin + kTileRows - 1) / kTileRows;
  parallel_each(size_t(across) * size_t(std::max(down, 0)), [&](size_t i) {
    const int x = int(i % size_t(across)) * kRun, y = begin + int(i / size_t(across)) * kTileRows;
    body(Tile{x, y, std::min(kRun, width - x), std::min(kTileRows, end - y)});
  });
}

}  // namespace emberline
