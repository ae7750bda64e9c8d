#include "renderer/reconstruction/align.h"

#include <array>
#include <cassert>
#include <cmath>

#include "renderer/reconstruction/halves.h"

namespace emberline {
namespace {

constexpr int kTaps = 4;
static_assert(kTaps / 2 + kOutlierRadius <= kNeighbourReach);

// The pixels around a position, and their weights.
struct Taps {
  bool known = false;
  int x = 0, y = 0;  // pixel of the first tap
  std::array<float, kTaps> across = {}, down = {};
};

std::array<float, kTaps> cubic_weights(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {0.5f * (-t3 + 2 * t2 - t), 0.5f * (3 * t3 - 5 * t2 + 2), 0.5f * (-3 * t3 + 4 * t2 + t),
          0.5f * (t3 - t2)};
}

Taps taps_at(float x, float y, int width, int height) {
  // The comparisons are written so that NaN counts as outside.
  const bool inside =
      x >= -0.5f && x <= float(width) - 0.5f && y >= -0.5f && y <= float(height) - 0.5f;
  if (!inside) return {};
  const float left = std::floor(x), top = std::floor(y);
  return {true, int(left) - 1, int(top) - 1, cubic_weights(x - left), cubic_weights(y - top)};
}

float interpolate(const BorderedPlane& plane, const Taps& taps) {
  float sum = 0.0f;
  for (int j = 0; j < kTaps; ++j) {
    const float* row = plane.clamped_row(taps.y + j) + taps.x;
    float line = 0.0f;
    for (int i = 0; i < kTaps; ++i) line += taps.across[size_t(i)] * row[i];
    sum += taps.down[size_t(j)] * line;
  }
  return sum;
}

bool has_samples(const BorderedPlane& counts, const Taps& taps) {
  for (int j = 0; j < kTaps; ++j) {
    const float* row = counts.clamped_row(taps.y + j) + taps.x;
    for (int i = 0; i < kTaps; ++i) {
      if (!(row[i] > 0.0f)) return false;
    }
  }
  return true;
}

}  // namespace

AlignedFrame::AlignedFrame(const NeighbourFrame& neighbour, int width, int height) {
  const DenoiseInput& from = neighbour.input;
  const auto pixels = size_t(width) * size_t(height);
  assert(from.width == width && neighbour.x.size() == pixels && neighbour.y.size() == pixels);
  Halves halves = prepare_colour(from);
  std::vector<BorderedPlane> sources;
  // Adds a pair of planes and returns the views of their aligned values. `planes_` must have enough
  // capacity.
  const auto add = [&](BorderedPlane a, BorderedPlane b) {
    HalfPlanes views;
    for (auto& [source, view] : {std::pair{&a, &views.a}, std::pair{&b, &views.b}}) {
      sources.push_back(std::move(*source));
      planes_.emplace_back(pixels, 0.0f);
      *view = planes_.back();
    }
    return views;
  };
  const auto add_feature = [&](const HalfPlanes& planes) {
    return add(padded_plane(planes.a, from.width, from.height),
               padded_plane(planes.b, from.width, from.height));
  };
  planes_.reserve(2 * (1 + 3 + 3 + from.features.size() + 3 * from.parts.size()));
  sources.reserve(planes_.capacity());
  input_.width = width;
  input_.height = height;
  for (Half& half : halves.half) {
    for (int y = 0; y < from.height; ++y) half.count.extend_row(y);
  }
  input_.samples = add(halves.half[0].count, halves.half[1].count);
  for (size_t c = 0; c < 3; ++c) {
    input_.colour[c] =
        add(std::move(halves.half[0].colour[c]), std::move(halves.half[1].colour[c]));
  }
  if (!from.albedo[0].a.empty()) {
    for (size_t c = 0; c < 3; ++c) input_.albedo[c] = add_feature(from.albedo[c]);
  }
  for (const HalfPlanes& planes : from.features) input_.features.push_back(add_feature(planes));
  for (const HalfColour& part : from.parts) {
    HalfColour& to = input_.parts.emplace_back();
    for (size_t c = 0; c < 3; ++c) {
      Channel channel = read_channel(halves, part[c]);
      to[c] = add(std::move(channel.half[0]), std::move(channel.half[1]));
    }
  }
  for_each_row(height, [&](int y) {
    const size_t first = size_t(y) * size_t(width);
    std::vector<std::pair<size_t, Taps>> known;  // pixels whose taps all have samples
    for (size_t i = first; i < first + size_t(width); ++i) {
      const Taps taps = taps_at(neighbour.x[i], neighbour.y[i], from.width, from.height);
      if (!taps.known || !has_samples(sources[0], taps) || !has_samples(sources[1], taps)) continue;
      known.emplace_back(i, taps);
    }
    for (size_t p = 0; p < sources.size(); ++p) {
      for (const auto& [i, taps] : known) planes_[p][i] = interpolate(sources[p], taps);
    }
    for (size_t s = 0; s < 2; ++s) {
      for (const auto& [i, taps] : known) planes_[s][i] = std::max(planes_[s][i], 0.0f);
    }
  });
}

}  // namespace emberline
