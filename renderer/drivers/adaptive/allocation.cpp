#include "renderer/drivers/adaptive/allocation.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Sums are made in parts of this many pixels and then in order, so that they do not depend on who
// computed which part.
constexpr size_t kPart = 8192;

float share(float rate, const SampleBounds& b, float k) {
  return std::clamp(k * rate, b.least, std::max(b.least, b.most));
}

double sum_of_shares(std::span<const float> rates, std::span<const SampleBounds> bounds, float k) {
  const size_t parts = (rates.size() + kPart - 1) / kPart;
  std::vector<double> sums(parts);
  parallel_each(parts, [&](size_t part) {
    const size_t begin = part * kPart, end = std::min(rates.size(), begin + kPart);
    float lanes[16] = {};  // so that the loop vectorises; each holds the sum of at most 512 counts
    for (size_t i = begin; i < end; ++i) lanes[i % 16] += share(rates[i], bounds[i], k);
    double sum = 0.0;
    for (const float lane : lanes) sum += double(lane);
    sums[part] = sum;
  });
  double total = 0.0;
  for (const double sum : sums) total += sum;
  return total;
}

}  // namespace

void share_samples(std::span<const float> rates, std::span<const SampleBounds> bounds, double total,
                   std::vector<float>* counts) {
  counts->resize(rates.size());
  // The sum grows with K; its logarithm is bracketed and halved, in which scale the sum bends
  // least.
  float most_rate = 0.0f, most_count = 0.0f;
  for (size_t i = 0; i < rates.size(); ++i) {
    most_rate = std::max(most_rate, rates[i]);
    most_count = std::max(most_count, bounds[i].most);
  }
  float k = 0.0f;
  if (most_rate > 0.0f) {
    float low = std::log2(std::max(1e-3f, most_count)) - std::log2(most_rate) - 24.0f;
    float high = low + 48.0f;
    // To a thousandth of the budget: stochastic rounding is coarser.
    constexpr int kSteps = 15;
    for (int step = 0; step < kSteps; ++step) {
      const float middle = 0.5f * (low + high);
      (sum_of_shares(rates, bounds, std::exp2(middle)) < total ? low : high) = middle;
    }
    k = std::exp2(low);
  }
  parallel_ranges(rates.size(), kPart, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) (*counts)[i] = share(rates[i], bounds[i], k);
  });
}

uint32_t round_count(uint32_t have, float wanted, uint32_t step, float u) {
  if (!(wanted > float(have))) return have;
  const auto lower = std::max(have, uint32_t(wanted) / step * step);
  const uint32_t upper = (lower / step + 1) * step;
  const float part = (wanted - float(lower)) / float(upper - lower);
  return u < part ? upper : lower;
}

}  // namespace emberline
