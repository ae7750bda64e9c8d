#include "renderer/reconstruction/box.h"

#include "renderer/core/parallel.h"

namespace emberline {

BorderedPlane box_sum(const BorderedPlane& in, int radius) {
  BorderedPlane out(in.width(), in.height());
  parallel_ranges(size_t(in.height()), 8, [&](size_t begin, size_t end) {
    const size_t columns = size_t(kPad + in.width() + kPad);
    std::vector<float> sums(columns);
    float* __restrict column = sums.data() + kPad;  // its border stays 0
    for (int y = int(begin); y < int(end); ++y) {
      std::fill(column, column + in.width(), 0.0f);
      for (int j = std::max(y - radius, 0); j <= std::min(y + radius, in.height() - 1); ++j) {
        const float* __restrict row = in.row(j);
        for (int x = 0; x < in.width(); ++x) column[x] += row[x];
      }
      float* __restrict to = out.row(y);
      for (int i = -radius; i <= radius; ++i) {
        for (int x = 0; x < in.width(); ++x) to[x] += column[x + i];
      }
    }
  });
  return out;
}

BorderedPlane box_mean(const BorderedPlane& in, int radius) {
  BorderedPlane mean = box_sum(in, radius);
  const auto inside = [radius](int at, int size) {
    return std::min(at + radius, size - 1) - std::max(at - radius, 0) + 1;
  };
  for_each_row(in.height(), [&](int y) {
    const int rows = inside(y, in.height());
    for (int x = 0; x < in.width(); ++x) {
      mean.row(y)[x] /= float(rows * inside(x, in.width()));
    }
  });
  return mean;
}

}  // namespace emberline
