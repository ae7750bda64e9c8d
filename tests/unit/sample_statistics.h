// Helpers for the statistical tests of samplers and filters: the chi-square threshold, a reader of
// sample points, and a straight-line fit.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "samplers/sampler.h"
#include "samplers/slot_numbers.h"

namespace emberline {

// The value that a chi-square variate with `degrees` of freedom exceeds with probability 1e-6, by
// Wilson & Hilferty 1931. z = 4.7534 is the normal quantile. Accurate to 1 % from 5 degrees on.
inline double chi_square_limit(double degrees) {
  const double a = 2.0 / (9.0 * degrees);
  const double root = 1.0 - a + 4.7534 * std::sqrt(a);
  return degrees * root * root * root;
}

// The sum of (observed - expected)^2 / expected over equal cells.
inline double chi_square(const std::vector<uint32_t>& counts) {
  double total = 0;
  for (const uint32_t count : counts) total += count;
  const double expected = total / double(counts.size());
  double sum = 0;
  for (const uint32_t count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

// The slope of the least-squares line through (x, y).
inline double slope(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0, mean_y = 0, xy = 0, xx = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    mean_x += x[i] / double(x.size());
    mean_y += y[i] / double(x.size());
  }
  for (size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    xx += (x[i] - mean_x) * (x[i] - mean_x);
  }
  return xy / xx;
}

// The numbers of one sample in one slot, from the smallest possible fill.
inline SlotNumbers read_sample(const Sampler& sampler, const PixelKey& pixel, uint32_t slot,
                               uint32_t sample) {
  SlotBlock block;
  sampler.fill(pixel, slot, sample, 1, block);
  SlotNumbers numbers;
  for (int d = 0; d < kSlotDimensions; ++d) numbers.u[d] = block.values[d][sample % kSampleLanes];
  return numbers;
}

// Describes how to replay a failing sample, for messages.
inline std::string where(std::string_view sampler, const PixelKey& pixel, uint32_t slot,
                         uint32_t sample) {
  return "replay: sampler " + std::string(sampler) + ", pixel (" + std::to_string(pixel.x) + ", " +
         std::to_string(pixel.y) + "), seed " + std::to_string(pixel.seed) + ", slot " +
         std::to_string(slot) + ", sample " + std::to_string(sample);
}

}  // namespace emberline
