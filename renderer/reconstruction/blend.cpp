#include "renderer/reconstruction/blend.h"

#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/reconstruction/box.h"

namespace emberline {
namespace {

constexpr size_t kPairs = size_t(kBandwidths) * (kBandwidths + 1) / 2;
constexpr size_t pair(size_t k, size_t l) {
  return k > l ? k * (k + 1) / 2 + l : l * (l + 1) / 2 + k;
}

// The terms of the error, of a pixel alone or pooled, in units of the pixel's squared brightness.
struct Terms {
  Plane unit;                            // what radiance is to be multiplied by, squared
  Plane noise;                           // V
  std::array<Plane, kBandwidths> gains;  // V - C_k
  std::array<Plane, kPairs> squares;     // D_kl
};

// Relative errors, so that a bright pixel does not decide for dark neighbours; below this (squared)
// radiance, where a display shows next to nothing, absolute ones.
constexpr float kDarkest = 1e-3f;

void measure_row(const Halves& h, const Candidates& candidates, int y, Terms& own) {
  const float *told = h.told.row(y), *noise = h.own_noise.row(y);
  float *unit = own.unit.row(y), *v = own.noise.row(y);
  for (int x = 0; x < h.width; ++x) {
    float brightness = 0.0f;
    for (const Plane& plane : candidates[0].colour) brightness += plane.row(y)[x];
    brightness = std::max(brightness * (1.0f / 3), 0.0f);
    unit[x] = 1.0f / (brightness * brightness + kDarkest);
    v[x] = noise[x] * unit[x];
  }
  for (size_t k = 0; k < kBandwidths; ++k) {
    const float* own_weight = candidates[k].own_weight.row(y);
    float* gain = own.gains[k].row(y);
    for (int x = 0; x < h.width; ++x) gain[x] = v[x] * (1.0f - own_weight[x]);
    for (size_t l = 0; l <= k; ++l) {
      float* square = own.squares[pair(k, l)].row(y);
      for (size_t c = 0; c < 3; ++c) {
        const float* raw = h.raw[c].row(y);
        const float *f = candidates[k].colour[c].row(y), *g = candidates[l].colour[c].row(y);
        for (int x = 0; x < h.width; ++x) {
          square[x] += (f[x] - raw[x]) * (g[x] - raw[x]) * unit[x] * told[x];
        }
      }
    }
  }
}

Terms measure(const Halves& h, const Candidates& candidates) {
  const auto planes = [&](auto& array) { array.fill(Plane(h.width, h.height)); };
  Terms own;
  own.unit = own.noise = Plane(h.width, h.height);
  planes(own.gains);
  planes(own.squares);
  parallel_each(size_t(h.height), [&](size_t y) { measure_row(h, candidates, int(y), own); });
  return own;
}

void pool(Terms& terms) {
  const auto one = [](Plane& plane) { plane = box_sum(plane, kBlendReach); };
  one(terms.noise);
  for (Plane& plane : terms.gains) one(plane);
  for (Plane& plane : terms.squares) one(plane);
}

// The shares, none below 0 nor their sum above 1, that make the error least, one after the other
// until they settle.
constexpr int kRounds = 16;

struct Least {
  std::array<float, kBandwidths> shares = {};
  float error = 0.0f;
};

Least least_error(float noise, const std::array<float, kBandwidths>& gains,
                  const std::array<float, kPairs>& squares) {
  Least least;
  std::array<float, kBandwidths>& a = least.shares;
  for (int round = 0; round < kRounds; ++round) {
    for (size_t k = 0; k < kBandwidths; ++k) {
      float gain = gains[k], rest = 1.0f;
      for (size_t l = 0; l < kBandwidths; ++l) {
        gain -= l == k ? 0.0f : a[l] * squares[pair(k, l)];
        rest -= l == k ? 0.0f : a[l];
      }
      const float square = squares[pair(k, k)];
      a[k] = gain > 0 ? std::max(std::min(gain / std::max(square, 1e-30f), rest), 0.0f) : 0.0f;
    }
  }
  least.error = noise;
  for (size_t k = 0; k < kBandwidths; ++k) {
    least.error -= 2 * a[k] * gains[k];
    for (size_t l = 0; l < kBandwidths; ++l) least.error += a[k] * a[l] * squares[pair(k, l)];
  }
  least.error = std::max(least.error, 0.0f);
  return least;
}

}  // namespace

Blend blend(const Halves& h, const Candidates& candidates) {
  Terms terms = measure(h, candidates);
  pool(terms);
  const Plane told = box_sum(h.told, kBlendReach);
  Blend out;
  out.shares.fill(Plane(h.width, h.height));
  out.error_before = out.error = Plane(h.width, h.height);
  parallel_each(size_t(h.height), [&](size_t row) {
    const int y = int(row);
    for (int x = 0; x < h.width; ++x) {
      std::array<float, kBandwidths> gains;
      std::array<float, kPairs> squares;
      for (size_t k = 0; k < kBandwidths; ++k) gains[k] = terms.gains[k].row(y)[x];
      for (size_t k = 0; k < kPairs; ++k) squares[k] = terms.squares[k].row(y)[x];
      Least least = least_error(terms.noise.row(y)[x], gains, squares);
      // A pixel without a sample is what its neighbours are.
      const bool sampled = h.half[0].known.row(y)[x] + h.half[1].known.row(y)[x] > 0;
      if (!sampled) least.shares = {1.0f};
      for (size_t k = 0; k < kBandwidths; ++k) out.shares[k].row(y)[x] = least.shares[k];
      const float scale = 1.0f / (told.row(y)[x] * terms.unit.row(y)[x]);
      const bool known = told.row(y)[x] > 0;
      out.error_before.row(y)[x] = known ? terms.noise.row(y)[x] * scale : -1.0f;
      out.error.row(y)[x] = known ? least.error * scale : -1.0f;
    }
  });
  return out;
}

}  // namespace emberline
