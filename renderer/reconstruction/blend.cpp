#include "renderer/reconstruction/blend.h"

#include <cmath>

#include "renderer/core/display_error.h"
#include "renderer/core/parallel.h"
#include "renderer/reconstruction/box.h"

namespace emberline {
namespace {

constexpr size_t kPairs = size_t(kBandwidths) * (kBandwidths + 1) / 2;
constexpr size_t pair(size_t k, size_t l) {
  return k > l ? k * (k + 1) / 2 + l : l * (l + 1) / 2 + k;
}

// The terms of the error (see blend.h), either of one pixel or pooled over neighbours, in units of
// the pixel's squared brightness.
struct Terms {
  BorderedPlane unit;  // factor on squared radiance; set only by measure()
  std::array<BorderedPlane, kBandwidths> gains;  // V - C_k
  std::array<BorderedPlane, kPairs> squares;     // D_kl
};

// Errors are relative, so that a bright pixel does not dominate its dark neighbours. Below this
// squared radiance, which is almost black on a display, errors are absolute.
constexpr float kMinSquaredRadiance = 1e-5f;
// This factor makes pixels in noisy neighbourhoods count less. Otherwise rare light, which few
// samples find, would drown the terms of the dark pixels around it. The value was chosen on the
// lamps' reflections in `thin_wires`, where dark pixels get worse with a smaller value
// (tests/bench/results/denoising.md).
constexpr float kNoiseWeight = 80.0f;

void measure_row(const Halves& h, const Candidates& candidates, int y, Terms& own) {
  const float *both_known = h.both_known.row(y), *noise = h.own_noise.row(y);
  const float *noise_a = h.half[0].noise.row(y), *share_a = h.share[0].row(y);
  float* unit = own.unit.row(y);
  for (int x = 0; x < h.width; ++x) {
    float brightness = 0.0f;
    for (const BorderedPlane& plane : candidates[0].colour) brightness += plane.row(y)[x];
    brightness = std::max(brightness * (1.0f / 3), 0.0f);
    const float variance = noise_a[x] * share_a[x] * (1.0f / 3);  // variance of one channel
    unit[x] = 1.0f / (brightness * brightness + kNoiseWeight * variance + kMinSquaredRadiance);
  }
  for (size_t k = 0; k < kBandwidths; ++k) {
    float* gain = own.gains[k].row(y);
    for (int x = 0; x < h.width; ++x) gain[x] = noise[x] * unit[x];
    for (size_t c = 0; c < 3; ++c) {
      const float *a = h.half[0].colour[c].row(y), *b = h.half[1].colour[c].row(y);
      const float* share_b = h.share[1].row(y);
      const float* d = candidates[k].difference[c].row(y);
      for (int x = 0; x < h.width; ++x) {
        gain[x] -= share_a[x] * share_b[x] * (a[x] - b[x]) * d[x] * unit[x] * both_known[x];
      }
    }
    for (size_t l = 0; l <= k; ++l) {
      float* square = own.squares[pair(k, l)].row(y);
      for (size_t c = 0; c < 3; ++c) {
        const float* raw = h.raw[c].row(y);
        const float *f = candidates[k].colour[c].row(y), *g = candidates[l].colour[c].row(y);
        for (int x = 0; x < h.width; ++x) {
          square[x] += (f[x] - raw[x]) * (g[x] - raw[x]) * unit[x] * both_known[x];
        }
      }
    }
  }
}

Terms empty_terms(const Halves& h) {
  Terms terms;
  terms.gains.fill(BorderedPlane(h.width, h.height));
  terms.squares.fill(BorderedPlane(h.width, h.height));
  return terms;
}

Terms measure(const Halves& h, const Candidates& candidates) {
  Terms own = empty_terms(h);
  own.unit = BorderedPlane(h.width, h.height);
  parallel_each(size_t(h.height), [&](size_t y) { measure_row(h, candidates, int(y), own); });
  return own;
}

// In rare light, most pixels are dark because their samples missed the light, and the filter is
// right to brighten them. Next to a lamp, dark pixels may really be dark. The half that saw a pixel
// dark cannot tell these cases apart, but the other half can, since it is independent. Pixels that
// one half saw darker than this fraction of their filtered value are pooled separately, and the
// other half measures how far these pixels should change.
constexpr float kDarkRatio = 0.25f;
// Noisy pixels count less in these pools, although they matter most, so the pooled fraction is
// multiplied by this factor. With this value, uniform noise is filtered as if dark pixels were not
// treated separately. This value and kDarkRatio were chosen on `thin_wires` and `hotel_room`
// (tests/bench/results/denoising.md).
constexpr float kDarkScale = 1.25f;

// Adds the terms of the dark pixels of both halves: (F_k - r)(r' - r) and (F_k - r)(F_l - r), where
// r and F_k belong to one half and r' belongs to the other half. The expectation of r' is the true
// value.
void measure_dark_row(const Halves& h, const Candidates& candidates, const BorderedPlane& units,
                      int y, Terms& dark) {
  const size_t width = size_t(h.width);
  const float *unit = units.row(y), *both_known = h.both_known.row(y);
  std::array<std::vector<float>, kBandwidths> change;
  for (size_t s = 0; s < 2; ++s) {
    const float* share = h.share[1 - s].row(y);
    const float sign = s == 0 ? 1.0f : -1.0f;
    std::vector<float> light(width, 0.0f), filtered(width, 0.0f);
    for (size_t c = 0; c < 3; ++c) {
      const float* own = h.half[s].colour[c].row(y);
      const Candidate& narrow = candidates.back();
      const float *f = narrow.colour[c].row(y), *d = narrow.difference[c].row(y);
      for (size_t x = 0; x < width; ++x) {
        light[x] += own[x];
        filtered[x] += f[x] + sign * share[x] * d[x];
      }
    }
    std::vector<float>& pixel_weights = light;
    for (size_t x = 0; x < width; ++x) {
      pixel_weights[x] = light[x] < kDarkRatio * filtered[x] ? unit[x] * both_known[x] : 0.0f;
    }
    for (size_t c = 0; c < 3; ++c) {
      const float *own = h.half[s].colour[c].row(y), *other = h.half[1 - s].colour[c].row(y);
      for (size_t k = 0; k < kBandwidths; ++k) {
        change[k].resize(width);
        float* gain = dark.gains[k].row(y);
        const float* f = candidates[k].colour[c].row(y);
        const float* d = candidates[k].difference[c].row(y);
        for (size_t x = 0; x < width; ++x) {
          change[k][x] = f[x] + sign * share[x] * d[x] - own[x];
          gain[x] += pixel_weights[x] * change[k][x] * (other[x] - own[x]);
        }
        for (size_t l = 0; l <= k; ++l) {
          float* square = dark.squares[pair(k, l)].row(y);
          for (size_t x = 0; x < width; ++x) {
            square[x] += pixel_weights[x] * change[k][x] * change[l][x];
          }
        }
      }
    }
  }
}

Terms measure_dark(const Halves& h, const Candidates& candidates, const BorderedPlane& units) {
  Terms dark = empty_terms(h);
  parallel_each(size_t(h.height),
                [&](size_t y) { measure_dark_row(h, candidates, units, int(y), dark); });
  return dark;
}

Terms pooled(const Terms& own, int radius) {
  Terms sums;
  for (size_t k = 0; k < kBandwidths; ++k) sums.gains[k] = box_sum(own.gains[k], radius);
  for (size_t k = 0; k < kPairs; ++k) sums.squares[k] = box_sum(own.squares[k], radius);
  return sums;
}

using Shares = std::array<float, kBandwidths>;

// For one pixel, `gain` is sum_k a_k (V - C_k), and `square` is sum_kl a_k a_l D_kl.
struct Change {
  float gain = 0.0f, square = 0.0f;
};
Change change_at(const Terms& terms, const Shares& a, int x, int y) {
  Change change;
  for (size_t k = 0; k < kBandwidths; ++k) {
    change.gain += a[k] * terms.gains[k].row(y)[x];
    for (size_t l = 0; l < kBandwidths; ++l) {
      change.square += a[k] * a[l] * terms.squares[pair(k, l)].row(y)[x];
    }
  }
  return change;
}

// least_error() finds the non-negative weights, with a sum of at most 1, that minimise the error.
// It uses coordinate descent.
constexpr int kIterations = 16;
constexpr float kMinBlendDivisor = 1e-30f;

Shares least_error(const Terms& terms, int x, int y) {
  Shares a = {};
  for (int round = 0; round < kIterations; ++round) {
    for (size_t k = 0; k < kBandwidths; ++k) {
      float gain = terms.gains[k].row(y)[x], rest = 1.0f;
      for (size_t l = 0; l < kBandwidths; ++l) {
        gain -= l == k ? 0.0f : a[l] * terms.squares[pair(k, l)].row(y)[x];
        rest -= l == k ? 0.0f : a[l];
      }
      const float square = terms.squares[pair(k, k)].row(y)[x];
      a[k] = gain > 0 ? std::max(std::min(gain / std::max(square, kMinBlendDivisor), rest), 0.0f)
                      : 0.0f;
    }
  }
  return a;
}

// The pooled weights may change a pixel and its nearest neighbours far more than their noise
// explains, for example next to a lamp whose noise dominates the pool. The weights are then limited
// to kMaxSupportRatio times the weights that are best for the nearest neighbours alone.
constexpr int kNearRadius = 1;
constexpr float kMaxSupportRatio = 3.0f;

// The weight of each candidate, and the fraction of this weight that is applied to dark pixels.
struct Choice {
  std::array<BorderedPlane, kBandwidths> shares;
  BorderedPlane dark_fraction;
};

Choice choose_shares(const Halves& h, const Terms& own, const Terms& own_dark) {
  const Terms wide = pooled(own, kPoolRadius), near = pooled(own, kNearRadius);
  const Terms dark = pooled(own_dark, kPoolRadius);
  Choice choice;
  choice.shares.fill(BorderedPlane(h.width, h.height));
  choice.dark_fraction = BorderedPlane(h.width, h.height);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    const Shares a = least_error(wide, x, y);
    const Change change = change_at(near, a, x, y);
    const bool doubtful = change.square > kMaxSupportRatio * change.gain;
    const float scale =
        doubtful ? std::max(kMaxSupportRatio * change.gain / change.square, 0.0f) : 1.0f;
    for (size_t k = 0; k < kBandwidths; ++k) choice.shares[k].row(y)[x] = scale * a[k];
    const Change dark_change = change_at(dark, a, x, y);
    choice.dark_fraction.row(y)[x] =
        dark_change.square > 0
            ? std::clamp(kDarkScale * dark_change.gain / dark_change.square, 0.0f, 1.0f)
            : 1.0f;
  });
  for (BorderedPlane& plane : choice.shares) plane = box_mean(plane, kSmoothRadius);
  choice.dark_fraction = box_mean(choice.dark_fraction, kSmoothRadius);
  return choice;
}

// Applies dark_fraction gradually: not at all where raw / filtered is kDarkRatio, fully at half
// that ratio.
void limit_dark_pixels(const Halves& h, const Candidates& candidates, Choice& choice) {
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    float raw = 0.0f, filtered = 0.0f;
    for (size_t c = 0; c < 3; ++c) {
      raw += h.raw[c].row(y)[x];
      filtered += candidates.back().colour[c].row(y)[x];
    }
    if (!(raw < kDarkRatio * filtered)) return;
    const float dark =
        std::min(2 - 2 / kDarkRatio * (raw / std::max(filtered, kMinBlendDivisor)), 1.0f);
    const float weight_scale = 1 - dark * (1 - choice.dark_fraction.row(y)[x]);
    for (BorderedPlane& plane : choice.shares) plane.row(y)[x] *= weight_scale;
  });
}

ColourPlanes mix(const Halves& h, const Candidates& candidates,
                 const std::array<BorderedPlane, kBandwidths>& shares) {
  ColourPlanes mixed = h.raw;
  for (size_t c = 0; c < 3; ++c) {
    for_each_row(h.height, [&](int y) {
      const float* raw = h.raw[c].row(y);
      float* to = mixed[c].row(y);
      for (size_t k = 0; k < kBandwidths; ++k) {
        const float *a = shares[k].row(y), *filtered = candidates[k].colour[c].row(y);
        for (int x = 0; x < h.width; ++x) to[x] += a[x] * (filtered[x] - raw[x]);
      }
    });
  }
  return mixed;
}

// A pixel without samples is fully filtered.
void fill_unknown(const Halves& h, std::array<BorderedPlane, kBandwidths>& shares) {
  for (int y = 0; y < h.height; ++y) {
    const float *a = h.half[0].known.row(y), *b = h.half[1].known.row(y);
    for (int x = 0; x < h.width; ++x) {
      if (a[x] + b[x] > 0) continue;
      for (size_t k = 0; k < kBandwidths; ++k) shares[k].row(y)[x] = k == 0 ? 1.0f : 0.0f;
    }
  }
}

// Upper bound on the squared error of a displayed value in [0, 1].
constexpr float kMaxSquaredError = 0.25f;

// Sums over a neighbourhood. Two small boxes in sequence reach as far as one box of kPoolRadius,
// but leave no visible edges around a bright pixel.
constexpr int kFirstPool = (kPoolRadius + 1) / 2, kSecondPool = kPoolRadius - kFirstPool;
BorderedPlane pool_smoothly(const BorderedPlane& own) {
  return box_sum(box_sum(own, kFirstPool), kSecondPool);
}

// Returns the typical weight of a pixel in pool_smoothly(): sum w^2 / sum w, over the weights w of
// the neighbourhood. It is 36 for two boxes of 9 x 9 pixels.
constexpr float pixel_weight() {
  float sum = 0.0f, squares = 0.0f;
  for (int i = -kPoolRadius; i <= kPoolRadius; ++i) {
    const int overlap = kPoolRadius + 1 - (i < 0 ? -i : i);
    const float weight = float(std::min(overlap, 2 * std::min(kFirstPool, kSecondPool) + 1));
    sum += weight;
    squares += weight * weight;
  }
  return (squares / sum) * (squares / sum);
}

// Returns the rarity of each pixel's light: 1 if one half saw all of the light, 0 if both saw the
// same amount.
BorderedPlane rarity(const Halves& h) {
  BorderedPlane rare(h.width, h.height);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    float a = 0.0f, b = 0.0f;
    for (size_t c = 0; c < 3; ++c) {
      a += h.half[0].colour[c].row(y)[x];
      b += h.half[1].colour[c].row(y)[x];
    }
    const float ratio = (a - b) / std::max(std::abs(a + b), kMinBlendDivisor);
    rare.row(y)[x] = std::min(ratio * ratio, 1.0f) * h.both_known.row(y)[x];
  });
  return rare;
}

// Adds the error of unseen rare light. Where few pixels have most of the error, both halves may
// have missed the light of another such pixel. So this function adds the expected error of one such
// pixel: the mean of the measured errors, weighted by error and rarity.
void add_unseen(const BorderedPlane& own, const BorderedPlane& rare, BorderedPlane& pool) {
  constexpr float kMaxPixelError = 1.0f;  // squared error of a displayed pixel
  BorderedPlane errors = own, squares = own;
  for_each_pixel(own.width(), own.height(), [&](int x, int y) {
    const float e = std::min(std::abs(own.row(y)[x]), kMaxPixelError);
    errors.row(y)[x] = e;
    squares.row(y)[x] = rare.row(y)[x] * e * e;
  });
  errors = pool_smoothly(errors);
  squares = pool_smoothly(squares);
  for_each_pixel(own.width(), own.height(), [&](int x, int y) {
    const float all = std::max(errors.row(y)[x], kMinBlendDivisor);
    pool.row(y)[x] += pixel_weight() * squares.row(y)[x] / all;
  });
}

// If `rare` is null, unseen light is ignored.
BorderedPlane pooled_error(const Halves& h, const BorderedPlane& own, const BorderedPlane* rare) {
  BorderedPlane error = pool_smoothly(own);
  if (rare != nullptr) add_unseen(own, *rare, error);
  const BorderedPlane both_known = pool_smoothly(h.both_known);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    float& e = error.row(y)[x];
    const float n = both_known.row(y)[x];
    // The order of the arguments matters: it turns NaN into the largest error.
    e = n > 0 ? std::max(std::min(kMaxSquaredError, e / n), 0.0f) : kMaxSquaredError;
  });
  return error;
}

// Like display_error_weight(), but for light, which cannot be negative: if the deviation exceeds
// the mean, the display curve's slope is measured from black. If mean and mean + deviation round to
// the same float, both are far outside the displayable range, and the slope is 0.
float light_error_weight(float mean, float deviation) {
  const float d = std::min(std::max(deviation, 1e-3f), 1e15f);
  const float low = std::max(mean - d, std::min(mean, 0.0f)), high = mean + d;
  const float slope = high > low ? (display_value(high) - display_value(low)) / (high - low) : 0.0f;
  return std::max(slope * slope, std::min(kMinDisplaySlope * kMinDisplaySlope, 0.25f / (d * d)));
}

// Evaluates the error of the displayed image for the chosen weights.
//
// If most of the noise is removed, this error is a small difference of large numbers. The variance
// measured from the difference of the blended halves is then more reliable, and serves as a lower
// bound.
void estimate_errors(const Halves& h, const Candidates& candidates, const Terms& own, Blend& out) {
  BorderedPlane before(h.width, h.height), after(h.width, h.height), variance(h.width, h.height);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    Shares a;
    for (size_t k = 0; k < kBandwidths; ++k) a[k] = out.shares[k].row(y)[x];
    const float retained = 1.0f - out.outlier_energy->own_fraction().row(y)[x];
    float value = 0.0f, square = 0.0f, spread = 0.0f;
    for (size_t c = 0; c < 3; ++c) {
      const float raw = h.half[0].colour[c].row(y)[x] - h.half[1].colour[c].row(y)[x];
      float d = raw;
      for (size_t k = 0; k < kBandwidths; ++k) {
        d += retained * a[k] * (candidates[k].difference[c].row(y)[x] - raw);
      }
      spread += d * d * (1.0f / 3);
      const float v = out.colour[c].row(y)[x], change = v - h.raw[c].row(y)[x];
      value += v * (1.0f / 3);
      square += change * change * (1.0f / 3);
    }
    const float gain = retained * change_at(own, a, x, y).gain / own.unit.row(y)[x] * (1.0f / 3);
    const float noise = h.own_noise.row(y)[x] * (1.0f / 3);
    const float weight = light_error_weight(value, std::sqrt(noise)) * h.both_known.row(y)[x];
    float excess = 0.0f;  // variance of the outliers' excess, estimated by its square
    for (const BorderedPlane& plane : h.excess) {
      const float light = std::max(plane.row(y)[x], 0.0f);  // values below black are not light
      excess += light * light * (1.0f / 3);
    }
    excess *= light_error_weight(value, std::sqrt(excess));
    for (size_t c = 0; c < 3; ++c) {
      const float input_noise = h.raw_noise[c].row(y)[x];
      const float slope = light_error_weight(out.colour[c].row(y)[x], std::sqrt(input_noise));
      before.row(y)[x] += input_noise * slope * h.both_known.row(y)[x] * (1.0f / 3);
    }
    after.row(y)[x] = (noise - 2 * gain + square) * weight + excess;
    variance.row(y)[x] = spread * h.share[0].row(y)[x] * h.share[1].row(y)[x] * weight + excess;
  });
  const BorderedPlane rare = rarity(h);
  out.error_before = pooled_error(h, before, nullptr);
  out.error = pooled_error(h, after, &rare);
  variance = pooled_error(h, variance, &rare);
  for_each_pixel(h.width, h.height, [&](int x, int y) {
    out.error.row(y)[x] = std::max(out.error.row(y)[x], variance.row(y)[x]);
  });
}

}  // namespace

Blend blend(const Halves& h, const Candidates& candidates) {
  const Terms own = measure(h, candidates);
  Blend out;
  Choice choice = choose_shares(h, own, measure_dark(h, candidates, own.unit));
  limit_dark_pixels(h, candidates, choice);
  out.shares = std::move(choice.shares);
  fill_unknown(h, out.shares);
  out.colour = mix(h, candidates, out.shares);
  out.outlier_energy.emplace(h, h.raw, out.colour);
  for (size_t c = 0; c < 3; ++c) out.outlier_energy->restore(h.raw[c], out.colour[c]);
  estimate_errors(h, candidates, own, out);
  return out;
}

}  // namespace emberline
