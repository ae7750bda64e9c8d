// Computes the sum over any rectangle of an image with four memory reads (Crow 1984, "Summed-Area
// Tables for Texture Mapping"). The sums are exact, because the values are integers.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/core/parallel.h"
#include "renderer/core/rect.h"

namespace emberline {

class SummedAreaTable {
 public:
  // value(i) returns the value of pixel i, where pixels are numbered in row order. It is called in
  // parallel.
  template <typename Value>
  SummedAreaTable(int width, int height, const Value& value)
      : pitch_(size_t(width) + 1), sums_(pitch_ * (size_t(height) + 1)) {
    constexpr size_t kRows = 8, kColumns = 256;
    parallel_each(size_t(height), kRows, [&](size_t y) {
      uint64_t* row = &sums_[(y + 1) * pitch_];
      for (size_t x = 0; x + 1 < pitch_; ++x) row[x + 1] = row[x] + value(y * (pitch_ - 1) + x);
    });
    parallel_ranges(pitch_, kColumns, [&](size_t begin, size_t end) {
      for (size_t y = 1; y <= size_t(height); ++y) {
        const uint64_t* above = &sums_[(y - 1) * pitch_];
        uint64_t* row = &sums_[y * pitch_];
        for (size_t x = begin; x < end; ++x) row[x] += above[x];
      }
    });
  }

  uint64_t operator()(const Rect& r) const {
    return at(r.x1, r.y1) - at(r.x0, r.y1) - at(r.x1, r.y0) + at(r.x0, r.y0);
  }

 private:
  uint64_t at(int x, int y) const { return sums_[size_t(y) * pitch_ + size_t(x)]; }

  size_t pitch_;
  std::vector<uint64_t> sums_;  // (x, y) holds the sum over [0, x) x [0, y)
};

}  // namespace emberline
