#include "renderer/drivers/adaptive/two_stream_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"

namespace emberline {
namespace {

constexpr int kRadius = 2;
// exp(-d^2 / (2 sigma^2)), sigma = 1.2 pixels, d = 0, 1, 2.
constexpr float kKernel[kRadius + 1] = {1.0f, 0.706648f, 0.249352f};

// How many of the streams' degrees of freedom the samples' own spread counts for: it keeps a pixel
// whose streams happen to agree from being thought finished.
constexpr float kPrior = 0.1f;

// Up to so many samples a pixel's own spread has no say in its next ones, because the unlucky ones
// would end: with 1 in its place, thin wires lose 3.6 % of their light at 64 samples instead
// of 2.1.
constexpr float kFewSamples = 64.0f;
// What the neighbours' spread counts for beside the samples that the pixel has beyond those.
constexpr float kPooledFreedom = 128.0f;

// What is pooled: weighted sums and the weights' sums.
enum Plane : int {
  kWeight,       // of the means: 1
  kMean,         // three
  kFreedom = 4,  // degrees of freedom of the samples' spread
  kSpread,       // three
  kStreams = 8,  // degrees of freedom of the streams' differences
  kDifference,   // three
  kSeen = 12,    // three: the differences as the display shows them
  kSquare = 15,  // three: of the means
  kPlanes = 18
};

// One row of every plane.
class PlaneRows {
 public:
  explicit PlaneRows(size_t width) : width_(width), values_(width * kPlanes) {}
  float* operator[](int plane) { return values_.data() + size_t(plane) * width_; }
  const float* operator[](int plane) const { return values_.data() + size_t(plane) * width_; }

 private:
  size_t width_;
  std::vector<float> values_;
};

void pool_across(const float* in, int width, float* out) {
  for (int x = 0; x < width; ++x) {
    out[x] = kKernel[2] * (in[x - 2] + in[x + 2]) + kKernel[1] * (in[x - 1] + in[x + 1]) + in[x];
  }
}

void pool_down(const std::array<const float*, 2 * kRadius + 1>& in, int width, float* out) {
  const auto [a, b, c, d, e] = in;
  for (int x = 0; x < width; ++x) {
    out[x] = kKernel[2] * (a[x] + e[x]) + kKernel[1] * (b[x] + d[x]) + c[x];
  }
}

// The rows of sums over the kernel's width, of which the sums over its height are made. Each is
// made once and kept until it is no longer under the kernel; so rows are asked for from above.
class PooledRows {
 public:
  PooledRows(const PixelStatistics& pixels, int first)
      : pixels_(pixels),
        next_(std::max(0, first - kRadius)),
        raw_(size_t(pixels.width) + 2 * kRadius),
        outside_(size_t(pixels.width)),
        across_(kHeight, PlaneRows(size_t(pixels.width))),
        pooled_(size_t(pixels.width)) {}

  const PlaneRows& row(int y) {
    for (; next_ <= std::min(y + kRadius, pixels_.height - 1); ++next_) add_row(next_);
    std::array<const PlaneRows*, kHeight> under;
    for (int i = 0; i < kHeight; ++i) {
      const int from = y + i - kRadius;
      const bool inside = from >= 0 && from < pixels_.height;
      under[size_t(i)] = inside ? &across_[size_t(from % kHeight)] : &outside_;
    }
    for (int plane = 0; plane < kPlanes; ++plane) {
      const auto in = [&](size_t i) { return (*under[i])[plane]; };
      pool_down({in(0), in(1), in(2), in(3), in(4)}, pixels_.width, pooled_[plane]);
    }
    return pooled_;
  }

 private:
  static constexpr int kHeight = 2 * kRadius + 1;

  void add_row(int y) {
    const size_t first = size_t(y) * size_t(pixels_.width);
    const float* count = &pixels_.count[first];
    const float* second = &pixels_.second_count[first];
    PlaneRows& out = across_[size_t(y % kHeight)];
    const auto pool = [&](int plane, const auto& value) {
      float* raw = raw_.data() + kRadius;  // with black margins
      for (int x = 0; x < pixels_.width; ++x) raw[x] = value(x);
      pool_across(raw, pixels_.width, out[plane]);
    };
    const auto freedom = [&](int x) { return std::max(0.0f, count[x] - 1.0f); };
    pool(kWeight, [&](int x) { return count[x] > 0.0f ? 1.0f : 0.0f; });
    pool(kFreedom, freedom);
    pool(kStreams, [&](int x) { return second[x] > 0.0f ? 1.0f : 0.0f; });
    for (int c = 0; c < 3; ++c) {
      const float* variance = &pixels_.variance[size_t(c)][first];
      const float* difference = &pixels_.stream_difference[size_t(c)][first];
      pool_across(padded(&pixels_.mean[size_t(c)][first]), pixels_.width, out[kMean + c]);
      pool(kSpread + c, [&](int x) { return freedom(x) * variance[x]; });
      // (A - B)^2 / (1/a + 1/b); the difference is 0 where there is no second stream.
      pool(kDifference + c, [&](int x) {
        const float a = count[x] - second[x], b = second[x];
        return difference[x] * difference[x] * (a * b / std::max(1.0f, a + b));
      });
      // Each at its own mean: that of the neighbours may be clipped white, or steeply dark.
      const float* mean = &pixels_.mean[size_t(c)][first];
      pool(kSquare + c, [&](int x) { return mean[x] * mean[x]; });
      pool(kSeen + c, [&](int x) {
        const float n = std::max(1.0f, count[x]), b = second[x], a = n - b;
        const float standard_error = std::sqrt(variance[x] / n);
        return difference[x] * difference[x] * (a * b / n) *
               display_error_weight(mean[x], standard_error);
      });
    }
  }
  const float* padded(const float* row) {
    std::copy(row, row + pixels_.width, raw_.data() + kRadius);
    return raw_.data() + kRadius;
  }

  const PixelStatistics& pixels_;
  int next_;                // row to be added
  std::vector<float> raw_;  // of one plane, with margins of 0
  PlaneRows outside_;       // 0, for rows outside the crop
  std::vector<PlaneRows> across_;
  PlaneRows pooled_;
};

// A number that takes part in sums and roots: no NaN, not negative, not so large that its square
// overflows.
float tame(float x) { return x > 0.0f ? std::min(x, 1e18f) : 0.0f; }

// Rows of what the three channels divide by.
struct Reciprocals {
  std::vector<float> count, weight, freedom, streams;
  explicit Reciprocals(size_t width)
      : count(width), weight(width), freedom(width), streams(width) {}

  void set(const float* counts, const PlaneRows& pooled) {
    invert(counts, 1.0f, &count);
    invert(pooled[kWeight], 1e-6f, &weight);
    // No stream, or no degree of freedom, gives a large number that is not asked for.
    invert(pooled[kFreedom], 1e-6f, &freedom);
    invert(pooled[kStreams], 1e-6f, &streams);
  }

 private:
  static void invert(const float* in, float least, std::vector<float>* row) {
    const size_t width = row->size();
    float* out = row->data();
    for (size_t x = 0; x < width; ++x) out[x] = 1.0f / std::max(least, in[x]);
  }
};

// Variances of a sample, of one channel: as the streams show it, as the samples' spread does, and
// the former as displayed.
struct Variances {
  float honest, spread, seen;
};

// The pixels' own counts, and means and spreads of one channel.
struct OwnRow {
  const float *count, *mean, *variance;
};

// The squared displayed error of a pixel that is darker than its neighbours, for they have met what
// it has missed. Light that a sample meets with chance p, and that makes a mean brighter by d, is
// worth d / p and gives samples the variance d^2 / p; n samples miss it with chance exp(-n p). With
// d^2 and variance of the neighbours p is theirs, so that a lamp in focus next to the pixel, which
// every other sample meets, is not thought missed. A quarter of n p, for who has met something rare
// by luck thinks it less rare than it is. (1 - x / 8)^8 stands for exp(-x).
float missed_error(float count, float mean, float neighbours, float their_square, float variance) {
  const float brighter = std::max(0.0f, neighbours - mean);
  const float square_brighter =
      std::max(brighter * brighter, their_square + mean * (mean - 2.0f * neighbours));
  const float expected = 0.25f * count * square_brighter / std::max(variance, 1e-30f);
  const float chance_2 = square(std::max(0.0f, 1.0f - 0.125f * expected));
  const float seen = display_value(neighbours) - display_value(mean);
  return brighter > 0.0f ? square(square(chance_2)) * square(seen) : 0.0f;
}

// A row of the map, and what its pixels have missed.
struct MapRow {
  float *error, *deviation, *missed;
};

// Adds a channel's squared errors and its part of the squared deviations to a row of the map. There
// are too many rows for the loop to check that they do not overlap, as it would without __restrict.
template <typename Metric>
void add_channel(const PlaneRows& pooled, const Reciprocals& per, const OwnRow& own, int c,
                 const Metric& metric, const MapRow& row) {
  float* __restrict error = row.error, * __restrict deviation = row.deviation, * __restrict missed = row.missed;
  const float *means = pooled[kMean + c], *spreads = pooled[kSpread + c],
              *differences = pooled[kDifference + c], *seens = pooled[kSeen + c],
              *squares = pooled[kSquare + c];
  const float *freedoms = pooled[kFreedom], *streams = pooled[kStreams];
  const float *per_weight = per.weight.data(), *per_freedom = per.freedom.data(),
              *per_stream = per.streams.data(), *per_count = per.count.data();
  const float *own_count = own.count, *own_mean = own.mean, *own_variance = own.variance;
  const size_t width = per.count.size();
  for (size_t x = 0; x < width; ++x) {
    const float mean = means[x] * per_weight[x];
    const float spread = freedoms[x] > 0.0f ? tame(spreads[x] * per_freedom[x]) : 1.0f;
    const float honest = streams[x] > 0.0f ? tame(differences[x] * per_stream[x]) : spread;
    const float display = display_error_weight(mean, std::sqrt(spread * per_count[x]));
    const float seen = streams[x] > 0.0f ? tame(seens[x] * per_stream[x]) : display * spread;
    error[x] += seen * per_count[x];
    missed[x] += missed_error(own_count[x], tame(own_mean[x]), tame(mean),
                              tame(squares[x] * per_weight[x]), honest);
    // How much wider the pixel's own samples spread than its neighbours', as far as it can tell.
    const float freedom = std::max(0.0f, own_count[x] - kFewSamples);
    const float own_share = freedom / (freedom + kPooledFreedom);
    const float wider =
        1.0f + own_share * (tame(own_variance[x]) / std::max(spread, 1e-30f) - 1.0f);
    deviation[x] += wider * metric(mean, display, Variances{honest, spread, seen});
  }
}

// metric(mean, display's weight, variances) is the allocation's squared deviation.
template <typename Metric>
void estimate_rows(const PixelStatistics& p, const Metric& metric, ErrorMap* out) {
  const auto width = size_t(p.width);
  constexpr size_t kRows = 16;
  std::vector<double> missed_of_rows(size_t(p.height));
  parallel_ranges(size_t(p.height), kRows, [&](size_t begin, size_t end) {
    PooledRows rows(p, int(begin));
    Reciprocals per(width);
    std::vector<float> missed(width);
    for (size_t y = begin; y < end; ++y) {
      const PlaneRows& pooled = rows.row(int(y));
      per.set(&p.count[y * width], pooled);
      float* error = &out->error[y * width];
      float* deviation = &out->deviation[y * width];
      std::fill(error, error + width, 0.0f);
      std::fill(deviation, deviation + width, 0.0f);
      std::ranges::fill(missed, 0.0f);
      for (int c = 0; c < 3; ++c) {
        const OwnRow own = {&p.count[y * width], &p.mean[size_t(c)][y * width],
                            &p.variance[size_t(c)][y * width]};
        add_channel(pooled, per, own, c, metric, {error, deviation, missed.data()});
      }
      missed_of_rows[y] = std::accumulate(missed.begin(), missed.end(), 0.0);
      for (size_t x = 0; x < width; ++x) {
        error[x] = std::sqrt(error[x] * (1.0f / 3));
        deviation[x] = std::sqrt(tame(deviation[x] * (1.0f / 3)));  // relmse of NaN is NaN
      }
    }
  });
  out->missed = std::accumulate(missed_of_rows.begin(), missed_of_rows.end(), 0.0);
}

}  // namespace

void estimate_two_stream(const PixelStatistics& p, const EstimatorSettings& settings,
                         ErrorMap* out) {
  const std::array<std::vector<float>*, 2> planes = {&out->error, &out->deviation};
  resize_planes(planes, p.size());
  constexpr float kWhole = 1.0f / (1.0f + kPrior);
  switch (settings.allocation) {
    case ErrorMetric::kDisplay:
    case ErrorMetric::kDenoised:  // until there is a denoised picture
      return estimate_rows(
          p,
          [](float, float display, const Variances& v) {
            return (v.seen + kPrior * display * v.spread) * kWhole;
          },
          out);
    case ErrorMetric::kMse:
      return estimate_rows(
          p,
          [](float, float, const Variances& v) { return (v.honest + kPrior * v.spread) * kWhole; },
          out);
    case ErrorMetric::kRelMse: {
      const float epsilon = rel_mse_epsilon(p);
      const auto metric = [epsilon](float mean, float, const Variances& v) {
        return (v.honest + kPrior * v.spread) * kWhole / (mean * mean + epsilon);
      };
      return estimate_rows(p, metric, out);
    }
  }
}

}  // namespace emberline
