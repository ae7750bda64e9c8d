#include "renderer/drivers/adaptive/two_stream_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

constexpr int kRadius = 2;
// exp(-d^2 / (2 sigma^2)), sigma = 1.2 pixels, d = 0, 1, 2.
constexpr float kKernel[kRadius + 1] = {1.0f, 0.706648f, 0.249352f};

// How many of the streams' degrees of freedom the samples' own spread counts for: it keeps a pixel
// whose streams happen to agree from being thought finished.
constexpr float kPrior = 0.1f;

// What is pooled: weighted sums and the weights' sums.
enum Plane : int {
  kWeight,       // of the means: 1
  kMean,         // three
  kFreedom = 4,  // degrees of freedom of the samples' spread
  kSpread,       // three
  kStreams = 8,  // degrees of freedom of the streams' differences
  kDifference,   // three
  kPlanes = 12
};

// Rows of sums over the kernel's height, then over its width.
class PooledRow {
 public:
  explicit PooledRow(int width) : width_(width) {
    for (auto* planes : {&vertical_, &pooled_}) {
      for (auto& plane : *planes) plane.resize(size_t(width + 2 * kRadius));
    }
  }

  void pool(const PixelStatistics& p, int y) {
    for (auto& plane : vertical_) std::fill(plane.begin(), plane.end(), 0.0f);
    for (int dy = -kRadius; dy <= kRadius; ++dy) {
      if (y + dy >= 0 && y + dy < p.height) add_row(p, y + dy, kKernel[std::abs(dy)]);
    }
    for (int plane = 0; plane < kPlanes; ++plane) {
      const float* in = vertical_[size_t(plane)].data() + kRadius;
      float* out = pooled_[size_t(plane)].data();
      for (int x = 0; x < width_; ++x) {
        out[x] =
            kKernel[2] * (in[x - 2] + in[x + 2]) + kKernel[1] * (in[x - 1] + in[x + 1]) + in[x];
      }
    }
  }
  float operator()(int plane, int x) const { return pooled_[size_t(plane)][size_t(x)]; }

 private:
  void add_row(const PixelStatistics& p, int y, float k) {
    const size_t first = size_t(y) * size_t(width_);
    const auto out = [&](int plane) { return vertical_[size_t(plane)].data() + kRadius; };
    const float* count = &p.count[first];
    const float* second = &p.second_count[first];
    float *weight = out(kWeight), *freedom = out(kFreedom), *streams = out(kStreams);
    for (int x = 0; x < width_; ++x) {
      weight[x] += count[x] > 0.0f ? k : 0.0f;
      freedom[x] += k * std::max(0.0f, count[x] - 1.0f);
      streams[x] += second[x] > 0.0f ? k : 0.0f;
    }
    for (int c = 0; c < 3; ++c) {
      const float* mean = &p.mean[size_t(c)][first];
      const float* variance = &p.variance[size_t(c)][first];
      const float* difference = &p.stream_difference[size_t(c)][first];
      float *means = out(kMean + c), *spreads = out(kSpread + c),
            *differences = out(kDifference + c);
      for (int x = 0; x < width_; ++x) {
        const float a = count[x] - second[x], b = second[x];
        means[x] += k * mean[x];
        spreads[x] += k * std::max(0.0f, count[x] - 1.0f) * variance[x];
        // (A - B)^2 / (1/a + 1/b); the difference is 0 where there is no second stream.
        differences[x] += k * difference[x] * difference[x] * (a * b / std::max(1.0f, a + b));
      }
    }
  }

  int width_;
  std::array<std::vector<float>, kPlanes> vertical_, pooled_;
};

// A number that takes part in sums and roots: no NaN, not negative, not so large that its square
// overflows.
float tame(float x) { return x > 0.0f ? std::min(x, 1e18f) : 0.0f; }

}  // namespace

void TwoStreamEstimator::estimate(const PixelStatistics& p, ErrorMetric allocation,
                                  ErrorMap* out) const {
  out->error.resize(p.size());
  out->deviation.resize(p.size());
  const float epsilon = rel_mse_epsilon(p);
  constexpr size_t kRows = 8;
  parallel_ranges(size_t(p.height), kRows, [&](size_t begin, size_t end) {
    PooledRow row(p.width);
    for (size_t y = begin; y < end; ++y) {
      row.pool(p, int(y));
      for (int x = 0; x < p.width; ++x) {
        const size_t i = y * size_t(p.width) + size_t(x);
        const float n = std::max(1.0f, p.count[i]);
        const float freedom = row(kFreedom, x), streams = row(kStreams, x);
        float error = 0.0f, variance = 0.0f;
        for (int c = 0; c < 3; ++c) {
          const float mean = row(kMean + c, x) / std::max(row(kWeight, x), 1e-6f);
          const float spread = freedom > 0.0f ? tame(row(kSpread + c, x) / freedom) : 1.0f;
          const float honest = streams > 0.0f ? tame(row(kDifference + c, x) / streams) : spread;
          const float deviation = std::sqrt(spread / n);
          const float display = error_weight(ErrorMetric::kDisplay, epsilon, mean, deviation);
          error += display * honest / n;
          const float weight = allocation == ErrorMetric::kDisplay
                                   ? display
                                   : error_weight(allocation, epsilon, mean, deviation);
          variance += weight * (honest + kPrior * spread) / (1.0f + kPrior);
        }
        out->error[i] = std::sqrt(error / 3);
        out->deviation[i] = std::sqrt(variance / 3);
      }
    }
  });
}

}  // namespace emberline
