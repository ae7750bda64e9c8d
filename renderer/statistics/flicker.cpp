#include "renderer/statistics/flicker.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "renderer/statistics/row_sums.h"

namespace emberline {
namespace {

// Returns the index of the pixel to which pixel (x, y) moves, or nullopt if it leaves the picture
// or is covered there.
std::optional<size_t> moved_pixel(const SequenceFrame& frame, const SequenceFrame& next, int x,
                                  int y) {
  constexpr float kSameMotion = 1;  // pixels
  const int width = frame.image.width, height = frame.image.height;
  const size_t i = size_t(y) * size_t(width) + size_t(x);
  if (frame.motion.empty()) return i;
  const float right = frame.motion.right[i], down = frame.motion.down[i];
  const float to_x = std::round(float(x) + right), to_y = std::round(float(y) + down);
  if (!(to_x >= 0 && to_x < float(width) && to_y >= 0 && to_y < float(height))) {
    return std::nullopt;
  }
  const size_t j = size_t(to_y) * size_t(width) + size_t(to_x);
  const bool is_same = next.motion.empty() || std::hypot(next.motion.right[j] - right,
                                                         next.motion.down[j] - down) <= kSameMotion;
  return is_same ? std::optional(j) : std::nullopt;
}

}  // namespace

double flicker(const SequenceFrame& frame, const SequenceFrame& next, double epsilon) {
  const int width = frame.image.width, height = frame.image.height;
  assert(next.image.width == width && next.image.height == height);
  constexpr double kSkipped = -1;
  std::vector<double> values(size_t(width) * size_t(height), kSkipped);
  for_each_row(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const std::optional<size_t> to = moved_pixel(frame, next, x, y);
      if (!to) continue;
      const size_t from = size_t(y) * size_t(width) + size_t(x);
      double sum = 0;
      for (size_t c = 0; c < 3; ++c) {
        const size_t i = 3 * from + c, j = 3 * *to + c;
        const double r = double(frame.reference.rgb[i]);
        const double change = double(next.image.rgb[j]) - double(next.reference.rgb[j]) -
                              (double(frame.image.rgb[i]) - r);
        sum += change * change / (r * r + epsilon);
      }
      if (std::isfinite(sum)) values[from] = sum / 3;
    }
  });
  std::erase(values, kSkipped);
  return values.empty() ? std::numeric_limits<double>::quiet_NaN()
                        : trimmed_mean(std::move(values));
}

}  // namespace emberline
