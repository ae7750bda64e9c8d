#include "renderer/reconstruction/motion_path.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

constexpr int kBackwardIterations = 2;

struct Position {
  float x, y;
};

// The motion at a position inside the frame, in pixels to the right and down. At integer
// coordinates, only that pixel is read.
Position motion_at(const VelocityRows& rows, const Position& p) {
  const float left = std::floor(p.x), top = std::floor(p.y);
  const float fx = p.x - left, fy = p.y - top;
  const auto pixel = [&](int x, int y) {
    x = std::clamp(x, 0, rows.width - 1);
    y = std::clamp(y, 0, rows.frame_height - 1) - rows.y0;
    return size_t(y) * size_t(rows.width) + size_t(x);
  };
  const int x = int(left), y = int(top);
  const int right = fx > 0 ? x + 1 : x, below = fy > 0 ? y + 1 : y;
  const size_t a = pixel(x, y), b = pixel(right, y), c = pixel(x, below), d = pixel(right, below);
  const auto mix = [&](std::span<const float> values) {
    if (values.empty()) return 0.0f;
    const float upper = (1 - fx) * values[a] + fx * values[b];
    const float lower = (1 - fx) * values[c] + fx * values[d];
    return (1 - fy) * upper + fy * lower;
  };
  return {mix(rows.right) + mix(rows.specular_right), -(mix(rows.up) + mix(rows.specular_up))};
}

}  // namespace

MotionPath::MotionPath(int width, int frame_height, int begin, int end)
    : width_(width), frame_height_(frame_height), begin_(begin), end_(end) {
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < width; ++x) {
      x_.push_back(float(x));
      y_.push_back(float(y));
    }
  }
}

// Calls step(position, known) for each known position; `known` tells whether a position is known
// and can be followed.
template <typename Step>
void MotionPath::move(const Step& step) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  parallel_each(size_t(end_ - begin_), [&](size_t row) {
    const float own_row = float(begin_ + int(row));
    // The comparisons are written so that NaN counts as unknown.
    const auto known = [&](const Position& p) {
      return p.x >= -0.5f && p.x <= float(width_) - 0.5f && p.y >= -0.5f &&
             p.y <= float(frame_height_) - 0.5f && std::abs(p.y - own_row) <= float(kMotionReach);
    };
    for (size_t i = row * size_t(width_); i < (row + 1) * size_t(width_); ++i) {
      Position p = {x_[i], y_[i]};
      if (known(p)) p = step(p, known);
      const bool reached = known(p);
      x_[i] = reached ? p.x : kUnknown;
      y_[i] = reached ? p.y : kUnknown;
    }
  });
}

void MotionPath::step_forward(const VelocityRows& here) {
  move([&](const Position& p, const auto&) {
    const Position v = motion_at(here, p);
    return Position{p.x + v.x, p.y + v.y};
  });
}

void MotionPath::step_back(const VelocityRows& here, const VelocityRows& there) {
  move([&](const Position& p, const auto& known) {
    Position v = motion_at(here, p), from = {p.x - v.x, p.y - v.y};
    for (int i = 0; i < kBackwardIterations && known(from); ++i) {
      v = motion_at(there, from);
      from = {p.x - v.x, p.y - v.y};
    }
    return from;
  });
}

}  // namespace emberline
