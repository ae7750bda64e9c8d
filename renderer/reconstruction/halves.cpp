#include "renderer/reconstruction/halves.h"

#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/box.h"
#include "renderer/reconstruction/feature_filter.h"

namespace emberline {
namespace {

// Squares of what is larger would not fit a float, summed.
constexpr float kLargest = 1e15f;

float finite(float value) {
  return std::isfinite(value) ? std::clamp(value, -kLargest, kLargest) : 0.0f;
}

// Of two independent means of n_a and n_b samples with the difference d: the variance of one
// sample.
float sample_variance(float d, float n_a, float n_b) {
  return n_a > 0 && n_b > 0 ? d * d * (n_a * n_b / (n_a + n_b)) : 0.0f;
}

// difference(x, y, n_a, n_b) of each pixel, as a mean over the neighbours whose halves are both
// known.
template <typename Difference>
Plane pooled_variance(const Halves& h, const Plane& told, const Difference& difference) {
  Plane single(h.width, h.height);
  parallel_each(size_t(h.height), [&](size_t row) {
    const int y = int(row);
    const float *n_a = h.half[0].count.row(y), *n_b = h.half[1].count.row(y);
    for (int x = 0; x < h.width; ++x) {
      single.row(y)[x] = difference(x, y, n_a[x], n_b[x]);
    }
  });
  Plane pooled = box_sum(single, kNoiseRadius);
  parallel_each(size_t(h.height), [&](size_t row) {
    const int y = int(row);
    for (int x = 0; x < h.width; ++x) pooled.row(y)[x] /= std::max(told.row(y)[x], 1.0f);
    pooled.extend_row(y);
  });
  return pooled;
}

void read_counts(const DenoiseInput& input, Halves& h) {
  h.half[0].count = padded_plane(input.samples.a, h.width, h.height);
  h.half[1].count = padded_plane(input.samples.b, h.width, h.height);
  for (size_t s = 0; s < 2; ++s) h.half[s].known = h.share[s] = Plane(h.width, h.height);
  h.told = Plane(h.width, h.height);
  parallel_each(size_t(h.height), [&](size_t row) {
    const int y = int(row);
    float *n_a = h.half[0].count.row(y), *n_b = h.half[1].count.row(y);
    for (int x = 0; x < h.width; ++x) {
      n_a[x] = std::max(n_a[x], 0.0f);
      n_b[x] = std::max(n_b[x], 0.0f);
      const float n = n_a[x] + n_b[x];
      h.half[0].known.row(y)[x] = n_a[x] > 0 ? 1.0f : 0.0f;
      h.half[1].known.row(y)[x] = n_b[x] > 0 ? 1.0f : 0.0f;
      h.told.row(y)[x] = n_a[x] > 0 && n_b[x] > 0 ? 1.0f : 0.0f;
      h.share[0].row(y)[x] = n > 0 ? n_a[x] / n : 0.5f;
      h.share[1].row(y)[x] = n > 0 ? n_b[x] / n : 0.5f;
    }
  });
}

void read_colour(const DenoiseInput& input, Halves& h) {
  h.own_noise = Plane(h.width, h.height);
  for (size_t c = 0; c < 3; ++c) {
    h.half[0].colour[c] = padded_plane(input.colour[c].a, h.width, h.height);
    h.half[1].colour[c] = padded_plane(input.colour[c].b, h.width, h.height);
    h.raw[c] = mean_of_halves(h, h.half[0].colour[c], h.half[1].colour[c]);
    parallel_each(size_t(h.height), [&](size_t row) {
      const int y = int(row);
      const float *n_a = h.half[0].count.row(y), *n_b = h.half[1].count.row(y);
      const float *a = h.half[0].colour[c].row(y), *b = h.half[1].colour[c].row(y);
      for (int x = 0; x < h.width; ++x) {
        const float n = std::max(n_a[x] + n_b[x], 1.0f);
        h.own_noise.row(y)[x] += sample_variance(a[x] - b[x], n_a[x], n_b[x]) / n;
      }
    });
  }
}

void measure_noise(Halves& h, const Plane& told) {
  const Plane variance = pooled_variance(h, told, [&](int x, int y, float n_a, float n_b) {
    return h.own_noise.row(y)[x] * (n_a + n_b);
  });
  for (Half& half : h.half) {
    half.noise = Plane(h.width, h.height);
    parallel_each(size_t(h.height), [&](size_t row) {
      const int y = int(row);
      for (int x = 0; x < h.width; ++x) {
        half.noise.row(y)[x] = variance.row(y)[x] / std::max(half.count.row(y)[x], 1.0f);
      }
      half.noise.extend_row(y);
    });
  }
}

Feature read_feature(const HalfPlanes& planes, const Halves& h, const Plane& told) {
  const Plane a = padded_plane(planes.a, h.width, h.height);
  const Plane b = padded_plane(planes.b, h.width, h.height);
  const Plane variance = pooled_variance(h, told, [&](int x, int y, float n_a, float n_b) {
    return sample_variance(a.row(y)[x] - b.row(y)[x], n_a, n_b);
  });
  return filter_feature(h, a, b, variance);
}

}  // namespace

Plane padded_plane(std::span<const float> values, int width, int height) {
  Plane plane(width, height);
  parallel_each(size_t(height), [&](size_t row) {
    const int y = int(row);
    const float* from = values.data() + row * size_t(width);
    for (int x = 0; x < width; ++x) plane.row(y)[x] = finite(from[x]);
    plane.extend_row(y);
  });
  return plane;
}

Plane mean_of_halves(const Halves& h, const Plane& a, const Plane& b) {
  Plane mean(h.width, h.height);
  parallel_each(size_t(h.height), [&](size_t row) {
    const int y = int(row);
    const float *in_a = h.share[0].row(y), *in_b = h.share[1].row(y);
    const float *from_a = a.row(y), *from_b = b.row(y);
    for (int x = 0; x < h.width; ++x) {
      mean.row(y)[x] = in_a[x] * from_a[x] + in_b[x] * from_b[x];
    }
  });
  return mean;
}

Halves prepare_halves(const DenoiseInput& input) {
  Halves h;
  h.width = input.width;
  h.height = input.height;
  read_counts(input, h);
  read_colour(input, h);
  const Plane told = box_sum(h.told, kNoiseRadius);
  measure_noise(h, told);
  if (!input.albedo[0].a.empty()) {
    for (size_t c = 0; c < 3; ++c) {
      h.features.push_back(read_feature(input.albedo[c], h, told));
      h.texture[c] = h.features.back().value;
    }
  }
  for (const HalfPlanes& planes : input.features) {
    h.features.push_back(read_feature(planes, h, told));
  }
  return h;
}

}  // namespace emberline
