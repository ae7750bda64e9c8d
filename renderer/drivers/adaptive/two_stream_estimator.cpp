#include "renderer/drivers/adaptive/two_stream_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/pooling.h"

namespace emberline {
namespace {

// The weight of the samples' pooled spread in the squared deviation. The pooled difference of the
// streams has weight 1. Without the spread, a pixel whose streams agree by chance would be
// allocated almost no samples.
constexpr float kSpreadWeight = 0.1f;

// A pixel's own spread is ignored up to this many samples, since otherwise pixels whose samples
// agree by chance would stop. With a limit of 64, thin wires lose 2.1 % of their light at 64
// samples; with a limit of 1, they lose 3.6 %.
constexpr float kFewSamples = 64.0f;
// The neighbours' spread weighs as much as this many of the pixel's own samples beyond kFewSamples.
constexpr float kPooledFreedom = 128.0f;

// The pooled values: weighted sums, and the sums of their weights.
enum Plane : int {
  kWeight,          // weight of the means: 1, or 0 without samples
  kMean,            // R G B
  kFreedom = 4,     // degrees of freedom of the samples' spread
  kSpread,          // R G B
  kStreams = 8,     // degrees of freedom of the streams' differences
  kDifference,      // R G B
  kDisplayed = 12,  // R G B: differences as displayed
  kPlanes = 15
};

class PlaneRows {
 public:
  explicit PlaneRows(size_t width) : width_(width), values_(width * kPlanes) {}
  float* operator[](int plane) { return values_.data() + size_t(plane) * width_; }
  const float* operator[](int plane) const { return values_.data() + size_t(plane) * width_; }

 private:
  size_t width_;
  std::vector<float> values_;
};

// Pools the values first along each row, and then down the columns (pooling.h). Of the results of
// the first step, keeps only the rows that the kernel covers. So row() must be called for rows from
// top to bottom.
class PooledRows {
 public:
  PooledRows(const PixelStatistics& pixels, int first)
      : pixels_(pixels),
        next_(std::max(0, first - kPoolRadius)),
        padded_row_(size_t(pixels.width) + 2 * kPoolRadius),
        zero_row_(size_t(pixels.width)),
        across_(kHeight, PlaneRows(size_t(pixels.width))),
        pooled_(size_t(pixels.width)) {}

  const PlaneRows& row(int y) {
    for (; next_ <= std::min(y + kPoolRadius, pixels_.height - 1); ++next_) add_row(next_);
    std::array<const PlaneRows*, kHeight> kernel_rows;
    for (int i = 0; i < kHeight; ++i) {
      const int from = y + i - kPoolRadius;
      const bool inside = from >= 0 && from < pixels_.height;
      kernel_rows[size_t(i)] = inside ? &across_[size_t(from % kHeight)] : &zero_row_;
    }
    for (int plane = 0; plane < kPlanes; ++plane) {
      const auto in = [&](size_t i) { return (*kernel_rows[i])[plane]; };
      pool_down({in(0), in(1), in(2), in(3), in(4)}, pixels_.width, pooled_[plane]);
    }
    return pooled_;
  }

 private:
  static constexpr int kHeight = 2 * kPoolRadius + 1;

  void add_row(int y) {
    const size_t first = size_t(y) * size_t(pixels_.width);
    const float* count = &pixels_.count[first];
    const float* second = &pixels_.second_count[first];
    PlaneRows& out = across_[size_t(y % kHeight)];
    const auto pool = [&](int plane, const auto& value) {
      float* raw = padded_row_.data() + kPoolRadius;  // with margins of 0
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
      pool_across(pad_row(&pixels_.mean[size_t(c)][first]), pixels_.width, out[kMean + c]);
      pool(kSpread + c, [&](int x) { return freedom(x) * variance[x]; });
      // Computes (A - B)^2 / (1/a + 1/b). The difference is 0 where there is no second stream.
      pool(kDifference + c, [&](int x) {
        const float a = count[x] - second[x], b = second[x];
        return difference[x] * difference[x] * (a * b / std::max(1.0f, a + b));
      });
      // Uses the display weight at the pixel's own mean (see the header).
      const float* mean = &pixels_.mean[size_t(c)][first];
      pool(kDisplayed + c, [&](int x) {
        const float n = std::max(1.0f, count[x]), b = second[x], a = n - b;
        const float standard_error = std::sqrt(variance[x] / n);
        return difference[x] * difference[x] * (a * b / n) *
               display_error_weight(mean[x], standard_error);
      });
    }
  }
  const float* pad_row(const float* row) {
    std::copy(row, row + pixels_.width, padded_row_.data() + kPoolRadius);
    return padded_row_.data() + kPoolRadius;
  }

  const PixelStatistics& pixels_;
  int next_;                       // next row to add
  std::vector<float> padded_row_;  // a row of one plane, with margins of 0
  PlaneRows zero_row_;             // all 0, for rows outside the crop
  std::vector<PlaneRows> across_;
  PlaneRows pooled_;
};

// Makes a value safe for sums, roots and squares: no NaN, not negative, limited.
float sanitize(float x) { return x > 0.0f ? std::min(x, 1e18f) : 0.0f; }

// Rows of reciprocals, shared by the three channels.
struct Reciprocals {
  std::vector<float> count, weight, freedom, streams;
  explicit Reciprocals(size_t width)
      : count(width), weight(width), freedom(width), streams(width) {}

  void set(const float* counts, const PlaneRows& pooled) {
    invert(counts, 1.0f, &count);
    invert(pooled[kWeight], 1e-6f, &weight);
    // Without a second stream or a degree of freedom, the reciprocal is large, but it is not used.
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

// Sample variances of one channel: from the streams' differences, from the samples' spread, and
// from the streams' differences as displayed.
struct Variances {
  float from_streams, spread, displayed;
};

// The pixels' own counts, and their sample variances of one channel.
struct OwnRow {
  const float *count, *variance;
};

// Adds a channel's squared errors and squared deviations to a row of the map. The rows are
// __restrict because there are too many for the compiler's overlap checks.
template <typename Metric>
void add_channel(const PlaneRows& pooled, const Reciprocals& per, const OwnRow& own, int c,
                 const Metric& metric, float* __restrict error, float* __restrict deviation) {
  const float *means = pooled[kMean + c], *spreads = pooled[kSpread + c],
              *differences = pooled[kDifference + c],
              *displayed_differences = pooled[kDisplayed + c];
  const float *freedoms = pooled[kFreedom], *streams = pooled[kStreams];
  const float *per_weight = per.weight.data(), *per_freedom = per.freedom.data(),
              *per_stream = per.streams.data(), *per_count = per.count.data();
  const float *own_count = own.count, *own_variance = own.variance;
  const size_t width = per.count.size();
  for (size_t x = 0; x < width; ++x) {
    const float mean = means[x] * per_weight[x];
    const float spread = freedoms[x] > 0.0f ? sanitize(spreads[x] * per_freedom[x]) : 1.0f;
    const float from_streams =
        streams[x] > 0.0f ? sanitize(differences[x] * per_stream[x]) : spread;
    const float display = display_error_weight(mean, std::sqrt(spread * per_count[x]));
    const float displayed =
        streams[x] > 0.0f ? sanitize(displayed_differences[x] * per_stream[x]) : display * spread;
    error[x] += displayed * per_count[x];
    // Ratio of the pixel's own spread to its neighbours' spread. The fewer samples the pixel has,
    // the closer the ratio is moved to 1.
    const float freedom = std::max(0.0f, own_count[x] - kFewSamples);
    const float own_share = freedom / (freedom + kPooledFreedom);
    const float spread_ratio =
        1.0f + own_share * (sanitize(own_variance[x]) / std::max(spread, 1e-30f) - 1.0f);
    deviation[x] +=
        spread_ratio * metric(mean, display, Variances{from_streams, spread, displayed});
  }
}

// metric(mean, display weight, variances) must return the squared deviation for the allocation.
template <typename Metric>
void estimate_rows(const PixelStatistics& p, const Metric& metric, ErrorMap* out) {
  const auto width = size_t(p.width);
  constexpr size_t kRows = 16;
  parallel_ranges(size_t(p.height), kRows, [&](size_t begin, size_t end) {
    PooledRows rows(p, int(begin));
    Reciprocals per(width);
    for (size_t y = begin; y < end; ++y) {
      const PlaneRows& pooled = rows.row(int(y));
      per.set(&p.count[y * width], pooled);
      float* error = &out->error[y * width];
      float* deviation = &out->deviation[y * width];
      std::fill(error, error + width, 0.0f);
      std::fill(deviation, deviation + width, 0.0f);
      for (int c = 0; c < 3; ++c) {
        const OwnRow own = {&p.count[y * width], &p.variance[size_t(c)][y * width]};
        add_channel(pooled, per, own, c, metric, error, deviation);
      }
      for (size_t x = 0; x < width; ++x) {
        error[x] = std::sqrt(error[x] * (1.0f / 3));
        deviation[x] = std::sqrt(sanitize(deviation[x] * (1.0f / 3)));  // relmse may be NaN
      }
    }
  });
}

}  // namespace

void estimate_two_stream(const PixelStatistics& p, const EstimatorSettings& settings,
                         ErrorMap* out) {
  const std::array<std::vector<float>*, 2> planes = {&out->error, &out->deviation};
  resize_planes(planes, p.size());
  constexpr float kNormalization = 1.0f / (1.0f + kSpreadWeight);
  switch (settings.allocation) {
    case ErrorMetric::kDisplay:
      return estimate_rows(
          p,
          [](float, float display, const Variances& v) {
            return (v.displayed + kSpreadWeight * display * v.spread) * kNormalization;
          },
          out);
    case ErrorMetric::kMse:
      return estimate_rows(
          p,
          [](float, float, const Variances& v) {
            return (v.from_streams + kSpreadWeight * v.spread) * kNormalization;
          },
          out);
    case ErrorMetric::kRelMse: {
      const float epsilon = rel_mse_epsilon(p);
      const auto metric = [epsilon](float mean, float, const Variances& v) {
        return (v.from_streams + kSpreadWeight * v.spread) * kNormalization /
               (mean * mean + epsilon);
      };
      return estimate_rows(p, metric, out);
    }
  }
}

}  // namespace emberline
