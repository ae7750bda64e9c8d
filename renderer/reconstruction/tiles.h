// Rectangles that one thread processes at a time. They are small enough for a core's caches.
#pragma once

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/bordered_plane.h"
#include "renderer/reconstruction/lanes.h"

namespace emberline {

inline constexpr int kTileRows = 8;

struct Tile {
  int x, y, columns, rows;  // at most kRun columns
};

// Calls body(tile) for each tile of rows [begin, end), in parallel.
template <typename Body>
void for_each_tile(int width, int begin, int end, const Body& body) {
  const int across = (width + kRun - 1) / kRun, down = (end - begin + kTileRows - 1) / kTileRows;
  parallel_each(size_t(across) * size_t(std::max(down, 0)), [&](size_t i) {
    const int x = int(i % size_t(across)) * kRun, y = begin + int(i / size_t(across)) * kTileRows;
    body(Tile{x, y, std::min(kRun, width - x), std::min(kTileRows, end - y)});
  });
}

// Position of an image's first pixel in the whole frame.
struct FrameOffset {
  int x = 0, y = 0;
};

// Like for_each_tile(), for a body that also writes up to half a tile around its tile. There are
// four phases, and each processes every other tile of every other row of tiles. Tiles, and the
// groups of kLanes pixels in them, are aligned to the whole frame. So contributions to a pixel are
// added in the same order for all threads, bands and crops. The first tiles may begin up to kLanes
// - 1 columns or kTileRows - 1 rows outside the image.
template <typename Body>
void for_each_tile_in_phases(int width, int begin, int end, FrameOffset frame_offset,
                             const Body& body) {
  const int left = frame_offset.x / kRun, right = (frame_offset.x + width - 1) / kRun;
  const int top = (frame_offset.y + begin) / kTileRows,
            bottom = (frame_offset.y + end - 1) / kTileRows;
  for (int phase = 0; phase < 4; ++phase) {
    const int x0 = left + (left + phase) % 2, y0 = top + (top + phase / 2) % 2;
    const int across = (right - x0) / 2 + 1, down = (bottom - y0) / 2 + 1;
    if (x0 > right || y0 > bottom) continue;
    parallel_each(size_t(across) * size_t(down), [&](size_t i) {
      const int column = (x0 + 2 * int(i % size_t(across))) * kRun - frame_offset.x;
      const int row = (y0 + 2 * int(i / size_t(across))) * kTileRows - frame_offset.y;
      const int x = std::max(column, -(frame_offset.x % kLanes));
      body(Tile{x, row, std::min(column + kRun, width) - x, kTileRows});
    });
  }
}

}  // namespace emberline
