#include "renderer/drivers/adaptive/missed_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "renderer/core/display_error.h"
#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/frame_error.h"
#include "renderer/drivers/adaptive/pooling.h"

namespace emberline {
namespace {

// kMaxRatio and kChanceScale were chosen on 23 scenes (tests/bench/results/adaptive.md).
constexpr float kMaxRatio = 2.5f;  // of a difference of means to its standard error
constexpr float kChanceScale = 0.45f;
constexpr size_t kRadius = kPoolRadius, kSide = 2 * kRadius + 1;
constexpr size_t kLanes = 64;  // pixels that are computed together, so that loops vectorise

// Makes a value safe for sums and squares: no NaN, not negative, limited.
float sanitize(float x, float limit) { return x > 0.0f ? std::min(x, limit) : 0.0f; }
constexpr float kMaxMean = 1e9f, kMaxVariance = 1e18f;

// A row of pixels, padded with pixels without samples: kRadius before the row; after it, enough to
// fill up to a multiple of kLanes, plus kRadius. Arrays of three planes are R, G, B.
class PixelRow {
 public:
  explicit PixelRow(size_t width) : width_(width) {
    const size_t padded = (width + kLanes - 1) / kLanes * kLanes + 2 * kRadius;
    count_.resize(padded);
    for (auto* planes : {&mean_, &squared_error_, &variance_}) {
      for (std::vector<float>& plane : *planes) plane.resize(padded);
    }
  }
  // Reads the row whose first pixel has this index.
  void read(const PixelStatistics& p, size_t first) {
    std::copy_n(&p.count[first], width_, &count_[kRadius]);
    const float *count = &p.count[first], *second = &p.second_count[first];
    for (size_t c = 0; c < 3; ++c) {
      const float *mean = &p.mean[c][first], *spread = &p.variance[c][first],
                  *difference = &p.stream_difference[c][first];
      float* __restrict means = &mean_[c][kRadius];
      float* __restrict squared_errors = &squared_error_[c][kRadius];
      float* __restrict variances = &variance_[c][kRadius];
      for (size_t x = 0; x < width_; ++x) {
        means[x] = sanitize(mean[x], kMaxMean);
        squared_errors[x] = sanitize(spread[x] / std::max(1.0f, count[x]), kMaxVariance);
        variances[x] =
            sanitize(sample_variance(count[x], second[x], difference[x], spread[x]), kMaxVariance);
      }
    }
  }
  // Each function returns kLanes values, beginning with the pixel at column x + dx - kRadius.
  const float* count(size_t x, size_t dx) const { return &count_[x + dx]; }
  const float* mean(size_t c, size_t x, size_t dx) const { return &mean_[c][x + dx]; }
  const float* squared_error(size_t c, size_t x, size_t dx) const {
    return &squared_error_[c][x + dx];
  }
  const float* variance(size_t c, size_t x, size_t dx) const { return &variance_[c][x + dx]; }

 private:
  size_t width_;
  std::vector<float> count_;
  std::array<std::vector<float>, 3> mean_;
  std::array<std::vector<float>, 3> squared_error_;  // of the mean
  std::array<std::vector<float>, 3> variance_;       // of a sample
};

// Weighted sums over the neighbours of kLanes pixels.
struct Sums {
  float weight[kLanes] = {}, mean[3][kLanes] = {}, square[3][kLanes] = {}, variance[3][kLanes] = {};
};

void add_neighbours(const PixelRow& own, const PixelRow& other, size_t x, size_t dx, float kernel,
                    Sums* sums) {
  float weight[kLanes];
  const float* count = other.count(x, dx);
  for (size_t l = 0; l < kLanes; ++l) weight[l] = count[l] > 0.0f ? kernel : 0.0f;
  // Three calls instead of a loop over the channels, which GCC would make the inner loop.
  const auto compare = [&](size_t c) {
    const float *a = own.mean(c, x, kRadius), *a_error = own.squared_error(c, x, kRadius),
                *b = other.mean(c, x, dx), *b_error = other.squared_error(c, x, dx);
    for (size_t l = 0; l < kLanes; ++l) {
      const float most = square(kMaxRatio) * (a_error[l] + b_error[l]);
      weight[l] = square(a[l] - b[l]) <= most ? weight[l] : 0.0f;
    }
  };
  const auto add = [&](size_t c) {
    const float *mean = other.mean(c, x, dx), *variance = other.variance(c, x, dx);
    float *means = sums->mean[c], *squares = sums->square[c], *variances = sums->variance[c];
    for (size_t l = 0; l < kLanes; ++l) {
      means[l] += weight[l] * mean[l];
      squares[l] += weight[l] * mean[l] * mean[l];
      variances[l] += weight[l] * variance[l];
    }
  };
  compare(0), compare(1), compare(2);
  for (size_t l = 0; l < kLanes; ++l) sums->weight[l] += weight[l];
  add(0), add(1), add(2);
}

// Returns the squared display error of a pixel that is darker than its neighbours, and 0 for a
// pixel without samples. Let p be the probability that a sample finds the light that the neighbours
// have found, and d the amount by which this light brightens the mean. The light adds d / p to a
// sample that finds it, and d^2 / p to the variance of a sample. So p is d^2 over the neighbours'
// variance. All n samples miss the light with probability exp(-n p); (1 - x / 8)^8 approximates
// exp(-x).
//
// d is estimated as the neighbours' mean minus the pixel's mean minus the pixel's standard error.
// The standard error is subtracted because the pixel's samples already show it. To compute p, d^2
// is replaced by the mean squared difference between the neighbours and the pixel if this is
// larger. Neighbours that found rare light by luck then make p too large, so p is multiplied by
// kChanceScale.
float missed_error(float count, float mean, float squared_error, float neighbours,
                   float neighbours_square, float variance) {
  const float explained = mean + std::sqrt(squared_error);
  const float increase = neighbours > explained ? neighbours - explained : 0.0f;
  const float spread = neighbours_square + mean * (mean - 2.0f * neighbours);
  const float squared_increase = std::max(square(increase), spread);
  const float expected = kChanceScale * count * squared_increase / std::max(variance, 1e-30f);
  const float chance_8 = std::max(0.0f, 1.0f - 0.125f * expected);
  const float displayed = display_value(mean + increase) - display_value(mean);
  return std::min(count, 1.0f) * square(square(square(chance_8)) * displayed);
}

float pool_weight(size_t offset) {
  return kPoolKernel[offset < kRadius ? kRadius - offset : offset - kRadius];
}

// `rows` has the row of the block's pixels in the middle, and its neighbouring rows around it. Rows
// outside the crop are null.
float missed_error_of_block(const std::array<const PixelRow*, kSide>& rows, size_t x) {
  const PixelRow& own = *rows[kRadius];
  Sums sums;
  for (size_t dy = 0; dy < kSide; ++dy) {
    if (!rows[dy]) continue;
    for (size_t dx = 0; dx < kSide; ++dx) {
      add_neighbours(own, *rows[dy], x, dx, pool_weight(dy) * pool_weight(dx), &sums);
    }
  }
  float error[kLanes] = {};
  const float* count = own.count(x, kRadius);
  for (size_t c = 0; c < 3; ++c) {
    const float *mean = own.mean(c, x, kRadius), *squared_error = own.squared_error(c, x, kRadius);
    for (size_t l = 0; l < kLanes; ++l) {
      const float per_weight = 1.0f / std::max(sums.weight[l], 1e-6f);
      error[l] += missed_error(count[l], mean[l], squared_error[l], sums.mean[c][l] * per_weight,
                               sums.square[c][l] * per_weight, sums.variance[c][l] * per_weight);
    }
  }
  return std::accumulate(std::begin(error), std::end(error), 0.0f);
}

}  // namespace

double missed_light_error(const PixelStatistics& pixels) {
  const auto width = size_t(pixels.width), height = size_t(pixels.height);
  std::vector<double> errors(height);
  constexpr size_t kRows = 16;
  parallel_ranges(height, kRows, [&](size_t begin, size_t end) {
    std::vector<PixelRow> ring(kSide, PixelRow(width));
    size_t next = begin - std::min(begin, kRadius);  // next row to read
    for (size_t y = begin; y < end; ++y) {
      for (; next < std::min(height, y + kRadius + 1); ++next) {
        ring[next % kSide].read(pixels, next * width);
      }
      std::array<const PixelRow*, kSide> rows;
      for (size_t i = 0; i < kSide; ++i) {
        // The row is y + i - kRadius, which may be negative.
        const bool inside = y + i >= kRadius && y + i < height + kRadius;
        rows[i] = inside ? &ring[(y + i - kRadius) % kSide] : nullptr;
      }
      for (size_t x = 0; x < width; x += kLanes) {
        errors[y] += double(missed_error_of_block(rows, x));
      }
    }
  });
  return std::accumulate(errors.begin(), errors.end(), 0.0);
}

}  // namespace emberline
