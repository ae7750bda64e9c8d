// Copies the pixels of a rectangle out of a frame or into it. Pixels are in row order. Each pixel
// has the same number of values, which are interleaved.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

template <class Values>
std::vector<typename Values::value_type> extract_rect(const Values& values, const Rect& frame,
                                                      const Rect& part) {
  const size_t count = values.size() / size_t(frame.area());
  const size_t row = size_t(part.width()) * count;
  std::vector<typename Values::value_type> extracted;
  extracted.reserve(row * size_t(part.height()));
  for (int y = part.y0; y < part.y1; ++y) {
    const auto* const first = values.data() + frame.index_of(part.x0, y) * count;
    extracted.insert(extracted.end(), first, first + row);
  }
  return extracted;
}

// Thread-safe if the parts are disjoint.
template <class Part, class Values>
void put_rect(const Part& pixels, const Rect& part, const Rect& frame, Values& values) {
  const size_t count = pixels.size() / size_t(part.area());
  const size_t row = size_t(part.width()) * count;
  assert(values.size() == count * size_t(frame.area()));
  for (int y = part.y0; y < part.y1; ++y) {
    std::copy_n(pixels.data() + size_t(y - part.y0) * row, row,
                values.data() + frame.index_of(part.x0, y) * count);
  }
}

}  // namespace emberline
