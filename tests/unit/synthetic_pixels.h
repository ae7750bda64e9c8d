// Synthetic pixels for the tests of error estimators: constant pixels, and pixels whose samples
// have a known distribution.
#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "support/chi_square.h"

namespace emberline::test {

// A pixel of one channel. Its samples go to two streams in blocks of eight, as in the samplers
// (samplers/sampler.h).
class SamplePixel {
 public:
  void add(double x) {
    const int stream = (count_ >> 3) & 1;
    sums_[stream] += x;
    squares_ += x * x;
    ++counts_[stream];
    ++count_;
  }
  uint32_t count() const { return count_; }
  uint32_t second_count() const { return counts_[1]; }
  double mean() const { return (sums_[0] + sums_[1]) / count_; }
  double variance() const {
    return std::max(0.0, squares_ - count_ * mean() * mean()) / (count_ - 1.0);
  }
  double stream_difference() const {
    return counts_[1] > 0 ? sums_[0] / counts_[0] - sums_[1] / counts_[1] : 0.0;
  }

 private:
  double sums_[2] = {0, 0}, squares_ = 0;
  uint32_t counts_[2] = {0, 0}, count_ = 0;
};

// Pixels with `count` equal samples each, half of them in the second stream.
inline PixelStatistics constant_pixels(int width, int height, float value, float count) {
  PixelStatistics pixels;
  pixels.resize(width, height);
  std::fill(pixels.count.begin(), pixels.count.end(), count);
  std::fill(pixels.second_count.begin(), pixels.second_count.end(), count / 2);
  std::fill(pixels.cost.begin(), pixels.cost.end(), 1.0f);
  for (auto& plane : pixels.mean) std::fill(plane.begin(), plane.end(), value);
  return pixels;
}

// Grey pixels with `count` samples each. draw(random) makes a sample, and `random` depends on
// `seed` and the pixel's index.
template <typename Draw>
PixelStatistics drawn_pixels(int width, int height, uint32_t count, uint64_t seed,
                             const Draw& draw) {
  PixelStatistics pixels = constant_pixels(width, height, 0.0f, float(count));
  for (size_t i = 0; i < pixels.size(); ++i) {
    TestRandom random(seed, i);
    SamplePixel pixel;
    for (uint32_t k = 0; k < count; ++k) pixel.add(draw(random));
    pixels.second_count[i] = float(pixel.second_count());
    for (size_t c = 0; c < 3; ++c) {
      pixels.mean[c][i] = float(pixel.mean());
      pixels.variance[c][i] = float(pixel.variance());
      pixels.stream_difference[c][i] = float(pixel.stream_difference());
    }
  }
  return pixels;
}

// A standard normal number, by Box & Muller 1958.
inline double draw_normal(TestRandom& random) {
  const double radius = std::sqrt(-2.0 * std::log1p(-random.next_double()));
  return radius * std::cos(2.0 * kPiD * random.next_double());
}

}  // namespace emberline::test
