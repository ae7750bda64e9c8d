// The mean of a texture over a triangle, for the power of emissive triangles.

#include <algorithm>
#include <cmath>

#include "renderer/core/warps.h"
#include "renderer/shading/texture.h"

namespace emberline {

namespace {

// If a triangle has more texels than this, or more rows, or more texels in a row, a regular subset
// is used. We chose the value: a triangle then takes 15 ms, and a sliver about 40 ms.
constexpr double kMaxTexels = double(1 << 22);
// If fewer texels than this are inside the triangle, filtered points are used instead.
constexpr int kMinTexels = 16;

int wrap_index(int64_t i, int size, WrapMode wrap) {
  switch (wrap) {
    case WrapMode::kRepeat: {
      const int64_t m = i % size;
      return int(m < 0 ? m + size : m);
    }
    case WrapMode::kMirroredRepeat: {
      int64_t m = i % (2 * int64_t(size));
      if (m < 0) m += 2 * int64_t(size);
      return int(m < size ? m : 2 * int64_t(size) - 1 - m);
    }
    case WrapMode::kClampToEdge:
      break;
  }
  return int(std::clamp<int64_t>(i, 0, size - 1));
}

}  // namespace

Rgb Texture::mean_over_triangle(const Vec2f& uv0, const Vec2f& uv1, const Vec2f& uv2) const {
  // Coordinates in texel units, where texel (i, j) has its centre at (i, j).
  double x[3], y[3];
  const Vec2f uv[3] = {transformed(uv0), transformed(uv1), transformed(uv2)};
  bool usable = true;
  for (int k = 0; k < 3; ++k) {
    x[k] = double(uv[k].x) * width_ - 0.5;
    y[k] = double(uv[k].y) * height_ - 0.5;
    usable = usable && std::abs(x[k]) < 1e9 && std::abs(y[k]) < 1e9;  // false for NaN
  }
  const double area = 0.5 * std::abs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]));
  double sum[3] = {0, 0, 0};
  int64_t count = 0;
  const auto add = [&](const Vec4f& texel) {
    for (int c = 0; c < 3; ++c) sum[c] += double(texel[c]);
    ++count;
  };

  if (usable && area >= kMinTexels) {
    const auto stride = int64_t(std::ceil(std::sqrt(std::max(1.0, area / kMaxTexels))));
    const auto [y_min, y_max] = std::minmax({y[0], y[1], y[2]});
    // A sliver can be long despite a small area: it has many rows of few texels each, or one row of
    // many texels.
    const auto first_row = int64_t(std::ceil(y_min)), last_row = int64_t(std::floor(y_max));
    const int64_t row_stride =
        std::max(stride, int64_t(std::ceil(double(last_row - first_row + 1) / kMaxTexels)));
    for (int64_t row = first_row; row <= last_row; row += row_stride) {
      double left = HUGE_VAL, right = -HUGE_VAL;
      for (int k = 0; k < 3; ++k) {
        const int n = (k + 1) % 3;
        const double lo = std::min(y[k], y[n]), hi = std::max(y[k], y[n]);
        if (double(row) < lo || double(row) > hi || lo == hi) continue;
        const double at = x[k] + (x[n] - x[k]) * ((double(row) - y[k]) / (y[n] - y[k]));
        left = std::min(left, at);
        right = std::max(right, at);
      }
      if (!(left <= right)) continue;
      const int j = wrap_index(row, height_, wrap_t_);
      const int64_t step = std::max(stride, int64_t(std::ceil((right - left) / kMaxTexels)));
      for (auto i = int64_t(std::ceil(left)); double(i) <= right; i += step) {
        add(texel(wrap_index(i, width_, wrap_s_), j));
      }
    }
  }
  if (count < kMinTexels) {
    std::fill(sum, sum + 3, 0.0);
    count = 0;
    for (int i = 0; i < 16; ++i) {  // 4 x 4 strata of the square, mapped with equal areas
      const Vec2f b = square_to_triangle(
          Vec2f((float(i % 4) + 0.5f) / 4.0f, (float(i / 4) + 0.5f) / 4.0f));  // NOLINT: integer
      add(bilinear(uv0 * (1.0f - b.x - b.y) + uv1 * b.x + uv2 * b.y));
    }
  }
  return Rgb(float(sum[0] / double(count)), float(sum[1] / double(count)),
             float(sum[2] / double(count)));
}

}  // namespace emberline
