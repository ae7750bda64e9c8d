#include "renderer/reconstruction/fast_filter.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/reconstruction/bordered_plane.h"
#include "renderer/reconstruction/lanes.h"

namespace emberline {
namespace {

// The following constants were tuned on four scenes of `scenes/` at 1 to 64 samples
// (tests/bench/results).
//
// Factor on the distance between two normals. At a scaled distance of 1, the normals are
// dissimilar.
constexpr float kNormalScale = 1.7f;
// Tolerated squared difference between two pixels, relative to their variance.
constexpr float kNoiseScale = 10.0f;
// Upper limit for a tap's variance, relative to the variance of the filtered pixel. Without this
// limit, lamps and rare bright samples would leak into the less noisy pixels around them.
constexpr float kMaxVarianceRatio = 4.0f;
constexpr float kSlopeTolerance = 2.0f;  // tolerated difference in nearness, relative to the slope
constexpr float kMinSlope = 0.005f;      // tolerance relative to the nearness itself
constexpr float kMinAlbedo = 0.02f;
constexpr int kNoiseReach = 2;
constexpr size_t kRows = 4;

constexpr float kRed = 0.2126f, kGreen = 0.7152f, kBlue = 0.0722f;  // as in luminance()
constexpr float kMaxColour = 1e12f;  // keeps squares and their sums finite
constexpr float kMinFilterDivisor = 1e-12f;

// Does not use std::clamp, because its references prevent vectorisation.
float clamp_colour(float value) {
  value = value < kMaxColour ? value : kMaxColour;
  return value > -kMaxColour ? value : -kMaxColour;
}

bool is_known(const float* rgba, const FeatureRow& row, int x) {
  bool finite = std::isfinite(row.nearness[x]);
  for (size_t k = 0; k < 3; ++k) {
    finite &= std::isfinite(rgba[4 * x + int(k)]) && std::isfinite(row.albedo[k][x]) &&
              std::isfinite(row.normal[k][x]);
  }
  return row.samples[x] > 0.0f && finite;
}

// A fast test whether all pixels of a row are known. It may return false for a known row whose sums
// overflow. So if it returns false, the caller checks each pixel.
bool all_known(int width, const float* __restrict rgba, const FeatureRow& row) {
  const float *ar = row.albedo[0], *ag = row.albedo[1], *ab = row.albedo[2];
  const float *nx = row.normal[0], *ny = row.normal[1], *nz = row.normal[2];
  const float *nearness = row.nearness, *samples = row.samples;
  int unknown = 0;
  for (int x = 0; x < width; ++x) {
    const float sum = rgba[4 * x] + rgba[4 * x + 1] + rgba[4 * x + 2] + ar[x] + ag[x] + ab[x] +
                      nx[x] + ny[x] + nz[x] + nearness[x];
    unknown |=
        int(!(std::abs(sum) < std::numeric_limits<float>::infinity())) | int(!(samples[x] > 0.0f));
  }
  return unknown == 0;
}

// Replaces unknown pixels by the nearest known pixel of the row.
void fill_unknown(int width, float* rgba, const FeatureRow& row) {
  std::vector<int> from(size_t(width), -1);
  for (int x = 0; x < width; ++x) {
    if (is_known(rgba, row, x)) {
      from[size_t(x)] = x;
    } else if (x > 0) {
      from[size_t(x)] = from[size_t(x - 1)];
    }
  }
  for (int x = width - 1, next = -1; x >= 0; --x) {
    int& source = from[size_t(x)];
    if (source == x) next = x;
    if (source < 0 || (next >= 0 && next - x < x - source)) source = next;
  }
  const auto fill = [&](float* values, int stride) {
    std::vector<float> old(values, values + (width - 1) * stride + 1);
    for (int x = 0; x < width; ++x) {
      const int source = from[size_t(x)];
      values[x * stride] = source < 0 ? 0.0f : old[size_t(source * stride)];
    }
  };
  for (int c = 0; c < 3; ++c) fill(rgba + c, 4);
  for (size_t k = 0; k < 3; ++k) {
    fill(row.albedo[k], 1);
    fill(row.normal[k], 1);
  }
  fill(row.nearness, 1);
  fill(row.variance, 1);
}

// The filter processes eight pixels at a time, because the sums of sixteen pixels do not fit into
// the AVX registers.
using Float8 = Lanes::Part;
constexpr int kAtOnce = kLanes / 2;

// Returns a * b + c. The result is rounded only once if the code is compiled for processors with
// FMA, so an image's last bits depend on the target processor.
[[gnu::always_inline]] inline Float8 fused(const Float8& a, const Float8& b, const Float8& c) {
#ifdef __FMA__
  return __builtin_ia32_vfmaddps256(a, b, c);
#else
  return a * b + c;
#endif
}

// Returns the reciprocals of positive numbers, with a relative error of up to 1/500. The code
// negates the exponent, then does one Newton step.
[[gnu::always_inline]] inline Float8 reciprocal(const Float8& value) {
  using Words [[gnu::vector_size(sizeof(Float8))]] = int32_t;
  const auto out = std::bit_cast<Float8>(0x7EF311C7 - std::bit_cast<Words>(value));
  return out * fused(-value, out, Float8{} + 2.0f);
}

// Divides one channel of the colour by its albedo. Writes the divisor to `albedo` and the quotient
// to `out`.
void demodulate_albedo(int width, int channel, const float* __restrict rgba, const FeatureRow& row,
                       float* __restrict albedo, float* __restrict out) {
  const float *red = row.albedo[0], *green = row.albedo[1], *blue = row.albedo[2];
  const float* own = row.albedo[size_t(channel)];
  for (int x = 0; x < width; ++x) {
    albedo[x] = own[x] + (red[x] + green[x] + blue[x] > 0.0f ? kMinAlbedo : 1.0f);
    out[x] = clamp_colour(rgba[4 * x + channel] / albedo[x]);
  }
}

// Converts red, green and blue to red - luminance, luminance and blue - luminance.
void to_luminance(int width, float* __restrict red, float* __restrict green,
                  float* __restrict blue) {
  for (int x = 0; x < width; ++x) {
    const float mean = kRed * red[x] + kGreen * green[x] + kBlue * blue[x];
    red[x] -= mean;
    blue[x] -= mean;
    green[x] = mean;
  }
}

// Computes the variance of the luminance after the division by albedo, and multiplies it by
// kNoiseScale. Writes -1 where the variance is unknown.
void scale_noise(int width, const float* __restrict variance, const float* __restrict red,
                 const float* __restrict green, const float* __restrict blue,
                 float* __restrict noise) {
  for (int x = 0; x < width; ++x) {
    const float albedo = kRed * red[x] + kGreen * green[x] + kBlue * blue[x];
    const float v = kNoiseScale * variance[x] / (albedo * albedo);
    const float known_noise = v < kMaxColour * kMaxColour ? v : kMaxColour * kMaxColour;
    noise[x] = known_noise >= 0.0f ? known_noise : -1.0f;
  }
}

// Square roots of the neighbours' weights 1/8 and 1/16; the pixel's own weight is 1/4.
constexpr float kSide = 0.353553391f, kCorner = 0.25f;

}  // namespace

class FastFilter::Planes {
 public:
  void filter(int width, int height, std::span<const float> rgba, const ReadRow& read, int levels,
              std::span<float> filtered) {
    resize(width, height);
    const auto each_row = [&](const auto& body) {
      parallel_each(size_t(height), kRows, [&](size_t y) { body(int(y)); });
    };
    prepare(rgba, read);
    each_row([&](int y) {
      find_slope(y);
      find_noise(y);
    });
    size_t from = 0;
    for (int level = 0; level < levels; ++level) {
      each_row([&](int y) { smooth(y, 1 << level, layers_[from], layers_[1 - from]); });
      from = 1 - from;
    }
    const size_t row = 4 * size_t(width);
    each_row([&](int y) {
      remodulate_albedo(y, layers_[from], &rgba[size_t(y) * row], &filtered[size_t(y) * row]);
    });
  }

 private:
  // The luminance, red minus luminance, blue minus luminance, and the variance of the luminance.
  struct Layer {
    BorderedPlane luminance, red, blue, variance;
  };

  // One row of all planes that a tap reads.
  struct TapRow {
    const float *luminance, *red, *blue, *variance, *normal[3], *nearness;

    TapRow(const Planes& filter, const Layer& from, int y)
        : luminance(from.luminance.clamped_row(y)),
          red(from.red.clamped_row(y)),
          blue(from.blue.clamped_row(y)),
          variance(from.variance.clamped_row(y)),
          normal{filter.normal_[0].clamped_row(y), filter.normal_[1].clamped_row(y),
                 filter.normal_[2].clamped_row(y)},
          nearness(filter.nearness_.clamped_row(y)) {}
  };

  // Eight pixels of a row, and the weighted sums over their surroundings.
  struct Taps {
    Float8 luminance, normal[3], nearness, variance, per_nearness;
    Float8 weight, noise, sum[3];

    [[gnu::always_inline]] Taps(const TapRow& row, const float* slope, float stride, int x) {
      load(row.luminance + x, luminance);
      for (size_t k = 0; k < 3; ++k) load(row.normal[k] + x, normal[k]);
      load(row.nearness + x, nearness);
      load(row.variance + x, variance);
      load(slope + x, per_nearness);
      per_nearness = reciprocal(kSlopeTolerance * stride * per_nearness + kMinSlope * nearness +
                                kMinFilterDivisor);
      variance += kMinFilterDivisor;
      weight = Float8{} + 0.25f;  // the pixel's own weight
      noise = 0.0625f * variance;
      sum[0] = 0.25f * luminance;
      load(row.red + x, sum[1]);
      load(row.blue + x, sum[2]);
      sum[1] = 0.25f * sum[1];
      sum[2] = 0.25f * sum[2];
    }

    // `root` is the square root of the tap's weight.
    [[gnu::always_inline]] void add(float root, const TapRow& row, int x) {
      Float8 l, v, u, red, blue;
      load(row.luminance + x, l);
      load(row.variance + x, v);
      load(row.nearness + x, u);
      const Float8 dl = l - luminance, du = (u - nearness) * per_nearness;
      const Float8 limit = kMaxVarianceRatio * variance;
      Float8 d = fused(dl * dl, reciprocal(variance + (v < limit ? v : limit)), du * du);
      for (size_t k = 0; k < 3; ++k) {
        load(row.normal[k] + x, u);
        u -= normal[k];
        d = fused(u, u, d);
      }
      const Float8 roots = Float8{} + root;
      Float8 t = fused(-roots, d, roots);
      t = t > 0.0f ? t : Float8{};
      const Float8 w = t * t;
      load(row.red + x, red);
      load(row.blue + x, blue);
      weight += w;
      noise = fused(w * w, v, noise);
      sum[0] = fused(w, l, sum[0]);
      sum[1] = fused(w, red, sum[1]);
      sum[2] = fused(w, blue, sum[2]);
    }
  };

  void resize(int width, int height) {
    int cache_slot = 0;
    const auto fit = [&](auto&... planes) { (planes.resize(width, height, cache_slot++), ...); };
    for (Layer& layer : layers_) fit(layer.luminance, layer.red, layer.blue, layer.variance);
    fit(normal_[0], normal_[1], normal_[2], nearness_, slope_, noise_);
    fit(albedo_[0], albedo_[1], albedo_[2]);
    width_ = width;
    height_ = height;
  }

  void prepare(std::span<const float> rgba, const ReadRow& read) {
    const size_t width = size_t(width_);
    parallel_ranges(size_t(height_), kRows, [&](size_t begin, size_t end) {
      thread_local std::vector<float> values;  // safe because a thread never reads two rows at once
      values.resize(13 * width);
      float* const colour = &values[9 * width];
      const auto column = [&](size_t i) { return &values[i * width]; };
      const FeatureRow row = {{column(0), column(1), column(2)},
                              {column(3), column(4), column(5)},
                              column(6),
                              column(7),
                              column(8)};
      for (size_t y = begin; y < end; ++y) {
        read(int(y), row);
        std::copy_n(&rgba[4 * width * y], 4 * width, colour);
        if (!all_known(width_, colour, row)) fill_unknown(width_, colour, row);
        prepare_row(int(y), colour, row);
      }
    });
  }

  void prepare_row(int y, const float* __restrict rgba, const FeatureRow& row) {
    Layer& layer = layers_[0];
    float* const planes[] = {layer.red.row(y), layer.luminance.row(y), layer.blue.row(y)};
    for (size_t k = 0; k < 3; ++k) {
      const float* __restrict n = row.normal[k];
      float* __restrict to = normal_[k].row(y);
      for (int x = 0; x < width_; ++x) to[x] = kNormalScale * n[x];
    }
    for (size_t k = 0; k < 3; ++k) {
      demodulate_albedo(width_, int(k), rgba, row, albedo_[k].row(y), planes[k]);
    }
    to_luminance(width_, planes[0], planes[1], planes[2]);
    scale_noise(width_, row.variance, albedo_[0].row(y), albedo_[1].row(y), albedo_[2].row(y),
                noise_.row(y));
    std::copy_n(row.nearness, width_, nearness_.row(y));
    for (BorderedPlane* plane : {&layer.luminance, &layer.red, &layer.blue, &nearness_, &noise_,
                                 &normal_[0], &normal_[1], &normal_[2]})
      plane->extend_row(y);
  }

  // A pixel's noise is the larger of its own estimate and the estimate from its neighbourhood. The
  // neighbourhood's estimate is the squared mean of the deviations, so that a few much noisier
  // pixels do not dominate. A pixel with a single sample has no estimate of its own. For such a
  // pixel, the function uses the spread of the surrounding luminances and the pixel's distance from
  // their mean.
  void find_noise(int y) {
    Layer& layer = layers_[0];
    thread_local std::vector<float> sums;
    const size_t stride = size_t(width_ + 2 * kPad);
    sums.assign(3 * stride, 0.0f);
    float* const __restrict sum = &sums[kPad];
    float* const __restrict squares = sum + stride;
    float* const __restrict known_noise = squares + stride;
    for (int j = -kNoiseReach; j <= kNoiseReach; ++j) {
      const float *l = layer.luminance.clamped_row(y + j), *v = noise_.clamped_row(y + j);
      for (int x = -kNoiseReach; x < width_ + kNoiseReach; ++x) {
        sum[x] += l[x];
        squares[x] += l[x] * l[x];
        known_noise[x] += std::sqrt(std::max(v[x], 0.0f));
      }
    }
    float* __restrict out = layer.variance.row(y);
    const float *own = noise_.row(y), *l = layer.luminance.row(y);
    constexpr float kInverseArea = 1.0f / (2 * kNoiseReach + 1) / (2 * kNoiseReach + 1);
    for (int x = 0; x < width_; ++x) {
      float a = 0, b = 0, c = 0;
      for (int i = -kNoiseReach; i <= kNoiseReach; ++i) {
        a += sum[x + i];
        b += squares[x + i];
        c += known_noise[x + i];
      }
      const float spread = std::max(b * kInverseArea - a * kInverseArea * (a * kInverseArea), 0.0f);
      const float off = l[x] - a * kInverseArea;
      out[x] = own[x] < 0.0f ? kNoiseScale * std::max(spread, off * off)
                             : std::max(c * kInverseArea * (c * kInverseArea), own[x]);
    }
    layer.variance.extend_row(y);
  }

  void find_slope(int y) {
    const float *here = nearness_.row(y), *above = nearness_.clamped_row(y - 1),
                *below = nearness_.clamped_row(y + 1);
    float* __restrict slope = slope_.row(y);
    for (int x = 0; x < width_; ++x) {
      const float across =
          std::min(std::abs(here[x + 1] - here[x]), std::abs(here[x] - here[x - 1]));
      const float down = std::min(std::abs(below[x] - here[x]), std::abs(here[x] - above[x]));
      slope[x] = std::max(across, down);
    }
  }

  void smooth(int y, int stride, const Layer& from, Layer& to) const {
    const TapRow above(*this, from, y - stride), row(*this, from, y),
        below(*this, from, y + stride);
    const float* slope = slope_.row(y);
    float *l = to.luminance.row(y), *red = to.red.row(y), *blue = to.blue.row(y),
          *variance = to.variance.row(y);
    for (int x = 0; x < width_; x += kAtOnce) {
      Taps taps(row, slope, float(stride), x);
      taps.add(kCorner, above, x - stride);
      taps.add(kSide, above, x);
      taps.add(kCorner, above, x + stride);
      taps.add(kSide, row, x - stride);
      taps.add(kSide, row, x + stride);
      taps.add(kCorner, below, x - stride);
      taps.add(kSide, below, x);
      taps.add(kCorner, below, x + stride);
      const Float8 per = 1.0f / taps.weight;
      store(taps.sum[0] * per, l + x);
      store(taps.sum[1] * per, red + x);
      store(taps.sum[2] * per, blue + x);
      store(taps.noise * per * per, variance + x);
    }
    for (BorderedPlane* plane : {&to.luminance, &to.red, &to.blue, &to.variance})
      plane->extend_row(y);
  }

  void remodulate_albedo(int y, const Layer& from, const float* __restrict rgba,
                         float* __restrict filtered) const {
    const float *l = from.luminance.row(y), *red = from.red.row(y), *blue = from.blue.row(y);
    const float *fr = albedo_[0].row(y), *fg = albedo_[1].row(y), *fb = albedo_[2].row(y);
    for (int x = 0; x < width_; ++x) {
      const float green = l[x] - (kRed * red[x] + kBlue * blue[x]) / kGreen;
      filtered[4 * x] = std::max((l[x] + red[x]) * fr[x], 0.0f);
      filtered[4 * x + 1] = std::max(green * fg[x], 0.0f);
      filtered[4 * x + 2] = std::max((l[x] + blue[x]) * fb[x], 0.0f);
      filtered[4 * x + 3] = rgba[4 * x + 3];
    }
  }

  int width_ = 0, height_ = 0;
  std::array<Layer, 2> layers_;
  std::array<BorderedPlane, 3> albedo_, normal_;
  BorderedPlane nearness_, slope_, noise_;
};

FastFilter::FastFilter() : planes_(std::make_unique<Planes>()) {}
FastFilter::~FastFilter() = default;

// More levels reduce noise further but blur details that no feature contains.
int FastFilter::levels_for(double samples_per_pixel) {
  return samples_per_pixel < 8.0 ? 4 : samples_per_pixel < 64.0 ? 3 : 2;
}

void FastFilter::filter(int width, int height, std::span<const float> rgba, const ReadRow& read,
                        int levels, std::span<float> filtered) {
  assert(rgba.size() == 4 * size_t(width) * size_t(height) && filtered.size() == rgba.size());
  assert(levels >= 0 && levels <= kMaxLevels);
  planes_->filter(width, height, rgba, read, levels, filtered);
}

}  // namespace emberline
