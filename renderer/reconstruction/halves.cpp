#include "renderer/reconstruction/halves.h"

#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/box.h"
#include "renderer/reconstruction/feature_filter.h"

namespace emberline {
namespace {

// The sums of squares of larger values would overflow float.
constexpr float kMaxValue = 1e15f;

float finite(float value) {
  return std::isfinite(value) ? std::clamp(value, -kMaxValue, kMaxValue) : 0.0f;
}

// Returns the variance of one sample, estimated from the difference d of two independent means of
// n_a and n_b samples.
float sample_variance(float d, float n_a, float n_b) {
  return n_a > 0 && n_b > 0 ? d * d * (n_a * n_b / (n_a + n_b)) : 0.0f;
}

// Returns the mean of difference(x, y, n_a, n_b) over the neighbours of which both halves are
// known. `both_known` is the number of such neighbours.
template <typename Difference>
BorderedPlane pooled_variance(const Halves& h, const BorderedPlane& both_known,
                              const Difference& difference) {
  BorderedPlane single(h.width, h.height);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    single.row(y)[x] = difference(x, y, h.half[0].count.row(y)[x], h.half[1].count.row(y)[x]);
  });
  BorderedPlane pooled = box_sum(single, kNoiseRadius);
  for_each_row(h.height, [&](int y) {
    for (int x = 0; x < h.width; ++x) pooled.row(y)[x] /= std::max(both_known.row(y)[x], 1.0f);
    pooled.extend_row(y);
  });
  return pooled;
}

void read_counts(const DenoiseInput& input, Halves& h) {
  h.half[0].count = padded_plane(input.samples.a, h.width, h.height);
  h.half[1].count = padded_plane(input.samples.b, h.width, h.height);
  for (size_t s = 0; s < 2; ++s) h.half[s].known = h.share[s] = BorderedPlane(h.width, h.height);
  h.both_known = BorderedPlane(h.width, h.height);
  for_each_row(h.height, [&](int y) {
    float *n_a = h.half[0].count.row(y), *n_b = h.half[1].count.row(y);
    for (int x = 0; x < h.width; ++x) {
      n_a[x] = std::max(n_a[x], 0.0f);
      n_b[x] = std::max(n_b[x], 0.0f);
      const float n = n_a[x] + n_b[x];
      h.half[0].known.row(y)[x] = n_a[x] > 0 ? 1.0f : 0.0f;
      h.half[1].known.row(y)[x] = n_b[x] > 0 ? 1.0f : 0.0f;
      h.both_known.row(y)[x] = n_a[x] > 0 && n_b[x] > 0 ? 1.0f : 0.0f;
      h.share[0].row(y)[x] = n > 0 ? n_a[x] / n : 0.5f;
      h.share[1].row(y)[x] = n > 0 ? n_b[x] / n : 0.5f;
    }
  });
}

// A pixel of a half is an outlier if it is this many times as bright as every other nearby pixel in
// either half. Neighbours say nothing about the light above this limit, so this excess stays in
// place, unfiltered. If a value is below black by more than this limit, it is not light, and its
// pixel stays entirely unfiltered.
constexpr float kOutlierRatio = 20.0f;

// For each pixel, the largest value of its channels, and how far the smallest value is below black.
struct Extremes {
  BorderedPlane brightest, below;  // their borders are black
};

Extremes extremes_of(const HalfColour& colour, size_t half, int width, int height) {
  Extremes extremes = {BorderedPlane(width, height), BorderedPlane(width, height)};
  for (const HalfPlanes& planes : colour) {
    const BorderedPlane one = padded_plane(half == 0 ? planes.a : planes.b, width, height);
    for (int y = 0; y < height; ++y) {
      float *brightest = extremes.brightest.row(y), *below = extremes.below.row(y);
      for (int x = 0; x < width; ++x) {
        brightest[x] = std::max(brightest[x], one.row(y)[x]);
        below[x] = std::max(below[x], -one.row(y)[x]);
      }
    }
  }
  return extremes;
}

void find_outliers(const HalfColour& colour, Halves& h) {
  const std::array<Extremes, 2> light = {extremes_of(colour, 0, h.width, h.height),
                                         extremes_of(colour, 1, h.width, h.height)};
  for (size_t s = 0; s < 2; ++s) {
    h.half[s].inlier_fraction = BorderedPlane(h.width, h.height);
    for_each_row(h.height, [&](int y) {
      const int first = std::max(y - kOutlierRadius, 0);
      const int last = std::min(y + kOutlierRadius, h.height - 1);
      std::vector<float> others(size_t(h.width), 0.0f);
      for (int j = first; j <= last; ++j) {
        for (int i = -kOutlierRadius; i <= kOutlierRadius; ++i) {
          const float *same = light[s].brightest.row(j) + i,
                      *other = light[1 - s].brightest.row(j) + i;
          const bool itself = i == 0 && j == y;
          for (int x = 0; x < h.width; ++x) {
            const float near = itself ? other[x] : std::max(same[x], other[x]);
            others[size_t(x)] = std::max(others[size_t(x)], near);
          }
        }
      }
      const float *own = light[s].brightest.row(y), *below = light[s].below.row(y);
      for (int x = 0; x < h.width; ++x) {
        const float limit = kOutlierRatio * others[size_t(x)];
        const float inlier_fraction = own[x] > limit ? limit / own[x] : 1.0f;
        h.half[s].inlier_fraction.row(y)[x] = below[x] > limit ? 0.0f : inlier_fraction;
      }
    });
  }
}

// Adds the variance of each pixel's mean, as estimated from its two halves, to `noise`.
void add_noise(const Halves& h, const BorderedPlane& first, const BorderedPlane& second,
               BorderedPlane& noise) {
  for_each_row(h.height, [&](int y) {
    const float *n_a = h.half[0].count.row(y), *n_b = h.half[1].count.row(y);
    const float *a = first.row(y), *b = second.row(y);
    for (int x = 0; x < h.width; ++x) {
      const float n = std::max(n_a[x] + n_b[x], 1.0f);
      noise.row(y)[x] += sample_variance(a[x] - b[x], n_a[x], n_b[x]) / n;
    }
  });
}

void read_colour(const HalfColour& colour, Halves& h) {
  for (size_t c = 0; c < 3; ++c) {
    Channel channel = read_channel(h, colour[c]);
    h.raw[c] = std::move(channel.raw);
    h.excess[c] = std::move(channel.excess);
    for (size_t s = 0; s < 2; ++s) h.half[s].colour[c] = std::move(channel.half[s]);
  }
  h.own_noise = BorderedPlane(h.width, h.height);
  for (size_t c = 0; c < 3; ++c) {
    add_noise(h, h.half[0].colour[c], h.half[1].colour[c], h.own_noise);
  }
}

void read_raw_noise(const HalfColour& colour, Halves& h) {
  for (size_t c = 0; c < 3; ++c) {
    h.raw_noise[c] = BorderedPlane(h.width, h.height);
    add_noise(h, padded_plane(colour[c].a, h.width, h.height),
              padded_plane(colour[c].b, h.width, h.height), h.raw_noise[c]);
  }
}

void measure_noise(Halves& h, const BorderedPlane& both_known) {
  const BorderedPlane variance = pooled_variance(
      h, both_known,
      [&](int x, int y, float n_a, float n_b) { return h.own_noise.row(y)[x] * (n_a + n_b); });
  for (Half& half : h.half) {
    half.noise = BorderedPlane(h.width, h.height);
    for_each_row(h.height, [&](int y) {
      for (int x = 0; x < h.width; ++x) {
        half.noise.row(y)[x] = variance.row(y)[x] / std::max(half.count.row(y)[x], 1.0f);
      }
      half.noise.extend_row(y);
    });
  }
}

Feature read_feature(const HalfPlanes& planes, const Halves& h, const BorderedPlane& both_known) {
  const BorderedPlane a = padded_plane(planes.a, h.width, h.height);
  const BorderedPlane b = padded_plane(planes.b, h.width, h.height);
  const BorderedPlane variance =
      pooled_variance(h, both_known, [&](int x, int y, float n_a, float n_b) {
        return sample_variance(a.row(y)[x] - b.row(y)[x], n_a, n_b);
      });
  return filter_feature(h, a, b, variance);
}

}  // namespace

BorderedPlane padded_plane(std::span<const float> values, int width, int height) {
  BorderedPlane plane(width, height);
  for_each_row(height, [&](int y) {
    const float* from = values.data() + size_t(y) * size_t(width);
    for (int x = 0; x < width; ++x) plane.row(y)[x] = finite(from[x]);
    plane.extend_row(y);
  });
  return plane;
}

Channel read_channel(const Halves& h, const HalfPlanes& planes) {
  Channel out;
  out.half = {padded_plane(planes.a, h.width, h.height), padded_plane(planes.b, h.width, h.height)};
  out.raw = out.excess = BorderedPlane(h.width, h.height);
  for_each_row(h.height, [&](int y) {
    for (size_t s = 0; s < 2; ++s) {
      const float *share = h.share[s].row(y), *inlier_fraction = h.half[s].inlier_fraction.row(y);
      float *value = out.half[s].row(y), *raw = out.raw.row(y), *excess = out.excess.row(y);
      for (int x = 0; x < h.width; ++x) {
        const float all = value[x];
        value[x] = inlier_fraction[x] * all;
        raw[x] += share[x] * value[x];
        excess[x] += share[x] * (all - value[x]);
      }
      out.half[s].extend_row(y);
    }
  });
  return out;
}

Halves prepare_colour(const DenoiseInput& input) {
  Halves h;
  h.width = input.width;
  h.height = input.height;
  read_counts(input, h);
  const bool shared = !input.shared[0].a.empty();
  const HalfColour& colour = shared ? input.shared : input.colour;
  find_outliers(colour, h);
  read_colour(colour, h);
  read_raw_noise(input.colour, h);
  measure_noise(h, box_sum(h.both_known, kNoiseRadius));
  return h;
}

Halves prepare_halves(const DenoiseInput& input) {
  Halves h = prepare_colour(input);
  const BorderedPlane both_known = box_sum(h.both_known, kNoiseRadius);
  if (!input.albedo[0].a.empty()) {
    for (size_t c = 0; c < 3; ++c) {
      h.features.push_back(read_feature(input.albedo[c], h, both_known));
    }
  }
  for (const HalfPlanes& planes : input.features) {
    h.features.push_back(read_feature(planes, h, both_known));
  }
  return h;
}

}  // namespace emberline
