#include "renderer/statistics/flicker.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <optional>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Returns the index of the pixel to which pixel (x, y) moves, or nullopt if it leaves the picture
// or is covered there.
std::optional<size_t> moved_pixel(const SequenceFrame& frame, const SequenceFrame& next, int x,
                                  int y) {
  constexpr float kSamePixels = 1, kSameShare = 0.25f;
  const int width = frame.image.width, height = frame.image.height;
  const size_t i = size_t(y) * size_t(width) + size_t(x);
  if (frame.motion.empty()) return i;
  const float right = frame.motion.right[i], down = frame.motion.down[i];
  const float to_x = std::round(float(x) + right), to_y = std::round(float(y) + down);
  if (!(to_x >= 0 && to_x < float(width) && to_y >= 0 && to_y < float(height))) {
    return std::nullopt;
  }
  const size_t j = size_t(to_y) * size_t(width) + size_t(to_x);
  const float same = std::max(kSamePixels, kSameShare * std::hypot(right, down));
  const bool is_same = next.motion.empty() ||
                       std::hypot(next.motion.right[j] - right, next.motion.down[j] - down) <= same;
  return is_same ? std::optional(j) : std::nullopt;
}

double relative_error(const SequenceFrame& frame, size_t i, double epsilon) {
  const double r = double(frame.reference.rgb[i]);
  return (double(frame.image.rgb[i]) - r) / std::sqrt(r * r + epsilon);
}

}  // namespace

Flicker flicker(const SequenceFrame& frame, const SequenceFrame& next, double epsilon) {
  const int width = frame.image.width, height = frame.image.height;
  assert(next.image.width == width && next.image.height == height);
  constexpr double kSkipped = -1;
  std::vector<double> values(size_t(width) * size_t(height), kSkipped);
  const auto pixels = double(values.size());
  for_each_row(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const std::optional<size_t> to = moved_pixel(frame, next, x, y);
      if (!to) continue;
      const size_t from = size_t(y) * size_t(width) + size_t(x);
      double sum = 0;
      for (size_t c = 0; c < 3; ++c) {
        const double before = relative_error(frame, 3 * from + c, epsilon);
        const double change = relative_error(next, 3 * *to + c, epsilon) - before;
        sum += change * change;
      }
      if (std::isfinite(sum)) values[from] = sum / 3;
    }
  });
  std::erase(values, kSkipped);
  if (values.empty()) return {};
  const double share = double(values.size()) / pixels;
  return {trimmed_mean(std::move(values)), share};
}

}  // namespace emberline
