// A plane of numbers with a border, so that loops over a window need no test at the picture's edge.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "renderer/core/parallel.h"

namespace emberline {

// Loops that do the same for all pixels of a row go by runs of so many: the compiler unrolls and
// vectorises what has a constant length.
inline constexpr int kRun = 64;
inline constexpr int kPad = 32;  // columns on either side that every window fits in

class BorderedPlane {
 public:
  BorderedPlane() = default;
  BorderedPlane(int width, int height) { resize(width, height); }
  // Keeps its memory; what is in it then is anything. Planes that are read together get different
  // places, from 0: else their rows would lie in the same few lines of the first-level cache.
  void resize(int width, int height, int place = 0) {
    width_ = width;
    height_ = height;
    stride_ = size_t(kPad + (width + 2 * kRun - 1) / kRun * kRun + kPad);
    offset_ = size_t(place) * kRun + kPad;
    values_.resize(std::max(values_.size(), offset_ + stride_ * size_t(height)));
  }

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return values_.empty(); }

  // Its pixel x = 0; readable from -kPad to kPad beyond a run that begins at any pixel.
  float* row(int y) { return values_.data() + size_t(y) * stride_ + offset_; }
  const float* row(int y) const { return values_.data() + size_t(y) * stride_ + offset_; }
  // The nearest row that there is.
  const float* near(int y) const { return row(std::clamp(y, 0, height_ - 1)); }

  // The border's values become those of the row's first and last pixel.
  void extend_row(int y) {
    float* values = row(y);
    std::fill(values - kPad, values, values[0]);
    std::fill(values + width_, values - kPad + stride_, values[width_ - 1]);
  }

 private:
  int width_ = 0, height_ = 0;
  size_t stride_ = 0, offset_ = 0;
  std::vector<float> values_;
};

// Calls body(y) for each row of a picture, in parallel.
template <typename Body>
void for_each_row(int height, const Body& body) {
  parallel_each(size_t(height), [&](size_t y) { body(int(y)); });
}

// Calls body(x, y) for each pixel of a picture, rows in parallel.
template <typename Body>
void for_each_pixel(int width, int height, const Body& body) {
  for_each_row(height, [&](int y) {
    for (int x = 0; x < width; ++x) body(x, y);
  });
}

}  // namespace emberline
