// A picture that is scaled down while it arrives in pieces, for reports and animations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/byte_image.h"
#include "renderer/core/rect.h"

namespace emberline {

class DisplayTransform;

// Averages linear R, G and B over squares of factor x factor pixels. The memory does not grow with
// the size of the frame. Not thread-safe.
class ScaledPicture {
 public:
  // `factor` is the smallest with which no side exceeds `max_side`.
  ScaledPicture(const Rect& crop, int max_side);

  // Adds a rectangle within the crop. Each pixel has `stride` values, the first three of which are
  // R, G and B. Each pixel must be added only once.
  void add(const Rect& rect, std::span<const float> values, size_t stride);

  int factor() const { return factor_; }
  int width() const { return width_; }
  int height() const { return height_; }
  size_t size() const { return counts_.size(); }
  // The index of the square that has the pixel of the frame.
  size_t index_of(int x, int y) const {
    return size_t((y - crop_.y0) / factor_) * size_t(width_) + size_t((x - crop_.x0) / factor_);
  }
  // Whether a pixel of this square has been added.
  bool has(size_t square) const { return counts_[square] > 0; }
  // Returns the picture as display values. Squares without pixels are black.
  ByteImage display(const DisplayTransform& transform) const;
  uint64_t bytes() const;

 private:
  Rect crop_;
  int factor_, width_, height_;
  std::vector<float> sums_;
  std::vector<uint32_t> counts_;
};

}  // namespace emberline
