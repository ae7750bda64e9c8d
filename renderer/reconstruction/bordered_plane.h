// A plane of floats with a border, so that loops over a window need no test at the image's edge.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "renderer/core/parallel.h"

namespace emberline {

// Loops that treat all pixels of a row alike process runs of this constant length, so that the
// compiler unrolls and vectorises them.
inline constexpr int kRun = 64;
inline constexpr int kPad = 32;  // columns on either side, enough for every window

class BorderedPlane {
 public:
  BorderedPlane() = default;
  BorderedPlane(int width, int height) { resize(width, height); }
  // Resizes the plane. It keeps its memory, but its contents become undefined. Planes that are read
  // together need different values of `cache_slot`, starting at 0. Otherwise their rows would
  // compete for the same few lines of the L1 cache.
  void resize(int width, int height, int cache_slot = 0) {
    width_ = width;
    height_ = height;
    stride_ = size_t(kPad + (width + 2 * kRun - 1) / kRun * kRun + kPad);
    offset_ = size_t(cache_slot) * kRun + kPad;
    values_.resize(std::max(values_.size(), offset_ + stride_ * size_t(height)));
  }

  int width() const { return width_; }
  int height() const { return height_; }

  // Returns a pointer to pixel x = 0. The caller may read a run that begins at any pixel, and kPad
  // values on either side of the run.
  float* row(int y) { return values_.data() + size_t(y) * stride_ + offset_; }
  const float* row(int y) const { return values_.data() + size_t(y) * stride_ + offset_; }
  // Like row(), but with y clamped to the image.
  const float* clamped_row(int y) const { return row(std::clamp(y, 0, height_ - 1)); }

  // Fills the border with the row's first and last pixel.
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

// Calls body(x, y) for each pixel of an image; rows are processed in parallel.
template <typename Body>
void for_each_pixel(int width, int height, const Body& body) {
  for_each_row(height, [&](int y) {
    for (int x = 0; x < width; ++x) body(x, y);
  });
}

}  // namespace emberline
