// Half-open pixel rectangles, [x0, x1) x [y0, y1). (0, 0) is the top-left pixel, and y grows
// downwards.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace emberline {

struct Rect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return std::max(0, x1 - x0); }
  int height() const { return std::max(0, y1 - y0); }
  int64_t area() const { return int64_t(width()) * height(); }
  // Pixels are numbered by rows from the top.
  size_t index_of(int x, int y) const { return size_t(y - y0) * size_t(width()) + size_t(x - x0); }
  int x_of(size_t i) const { return x0 + int(i % size_t(width())); }
  int y_of(size_t i) const { return y0 + int(i / size_t(width())); }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
  Rect intersect(const Rect& o) const {
    return {std::max(x0, o.x0), std::max(y0, o.y0), std::min(x1, o.x1), std::min(y1, o.y1)};
  }
  bool operator==(const Rect&) const = default;
};

}  // namespace emberline
