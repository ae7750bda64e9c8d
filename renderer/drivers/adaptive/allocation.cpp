#include "renderer/drivers/adaptive/allocation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/ordered_sum.h"

namespace emberline {
namespace {

// std::max(a, b) returns a if b is NaN, so a NaN rate counts as 0.
float share(float rate, float least, float most, float k) {
  return std::min(std::max(least, k * rate), std::max(least, most));
}

// Extremes and sums of rates and bounds, which limit K.
struct Extent {
  float most_rate = 0.0f, least_rate = std::numeric_limits<float>::max(), most_count = 0.0f;
  double rates = 0.0;
  double least = 0.0;  // the sum of counts for K = 0
  double most = 0.0;   // the sum of counts for K -> infinity

  Extent& operator+=(const Extent& other) {
    most_rate = std::max(most_rate, other.most_rate);
    least_rate = std::min(least_rate, other.least_rate);  // of the positive rates
    most_count = std::max(most_count, other.most_count);
    rates += other.rates;
    least += other.least;
    most += other.most;
    return *this;
  }
};

Extent extent_of_part(const float* rates, const SampleBounds* bounds, size_t begin, size_t end) {
  struct Lanes {
    float most_rate[kSumLanes] = {}, most_count[kSumLanes] = {}, least_rate[kSumLanes];
    float rates[kSumLanes] = {}, least[kSumLanes] = {}, most[kSumLanes] = {};
  } lanes;
  std::ranges::fill(lanes.least_rate, std::numeric_limits<float>::max());
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float rate = std::max(0.0f, rates[i]), least = bounds[i].least;
    const float most = std::max(least, bounds[i].most);
    const bool grows = rate > 0.0f;
    lanes.most_rate[lane] = std::max(lanes.most_rate[lane], rate);
    lanes.least_rate[lane] = std::min(lanes.least_rate[lane], grows ? rate : 3e38f);
    lanes.most_count[lane] = std::max(lanes.most_count[lane], most);
    lanes.rates[lane] += rate;
    lanes.least[lane] += least;
    lanes.most[lane] += grows ? most : least;
  });
  return {std::ranges::max(lanes.most_rate),  std::ranges::min(lanes.least_rate),
          std::ranges::max(lanes.most_count), sum_of_lanes(lanes.rates),
          sum_of_lanes(lanes.least),          sum_of_lanes(lanes.most)};
}

Extent extent_of(std::span<const float> rates, std::span<const SampleBounds> bounds) {
  return ordered_sum(rates.size(), [&](size_t begin, size_t end) {
    return extent_of_part(rates.data(), bounds.data(), begin, end);
  });
}

// The sum of all shares for a K, and its derivative by K: the sum of the rates within their bounds.
struct Shared {
  double sum = 0.0, slope = 0.0;
  Shared& operator+=(const Shared& other) {
    sum += other.sum;
    slope += other.slope;
    return *this;
  }
};

Shared shared_by_part(const float* rates, const SampleBounds* bounds, size_t begin, size_t end,
                      float k) {
  struct Lanes {
    float sum[kSumLanes] = {}, slope[kSumLanes] = {};
  } lanes;
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float wanted = k * rates[i], least = bounds[i].least, most = bounds[i].most;
    lanes.sum[lane] += share(rates[i], least, most, k);
    lanes.slope[lane] += wanted > least && wanted < most ? rates[i] : 0.0f;
  });
  return {sum_of_lanes(lanes.sum), sum_of_lanes(lanes.slope)};
}

// K whose shares add up to `total`. The sum is piecewise linear in K, so Newton's step is exact
// once it stays on one piece. A step that leaves the bracket, and every fourth step, is replaced by
// halving the bracket in logarithm.
float find_scale(std::span<const float> rates, std::span<const SampleBounds> bounds, double total) {
  const Extent extent = extent_of(rates, bounds);
  if (!(extent.most_rate > 0.0f) || total <= extent.least) return 0.0f;
  const double most_count = std::max(1e-3, double(extent.most_count));
  // Where even the smallest rate reaches its maximum, limited to what a float can hold.
  double high = std::min(2.0 * most_count / double(extent.least_rate), 0x1p126);
  if (total >= extent.most) return float(high);
  double low = 0x1p-24 * most_count / double(extent.most_rate);
  double k = std::clamp(total / extent.rates, low, high);
  // Newton's last step corrects the remaining thousandth; random rounding is coarser.
  const double close = 1e-3 * total;
  constexpr int kMostSteps = 100;
  for (int step = 0; step < kMostSteps && high > low * (1 + 1e-6); ++step) {
    const Shared shared = ordered_sum(rates.size(), [&](size_t begin, size_t end) {
      return shared_by_part(rates.data(), bounds.data(), begin, end, float(k));
    });
    (shared.sum < total ? low : high) = k;
    const double newton = k + (total - shared.sum) / shared.slope;
    const bool inside = newton > low && newton < high;
    if (std::abs(shared.sum - total) <= close) return float(inside ? newton : k);
    k = inside && step % 4 != 3 ? newton : std::sqrt(low * high);
  }
  return float(k);
}

// Powers of two are better stratified, so they get ratios from 1/1.23 to 1.3, and 1.5 times a power
// of two gets the rest. Our choice, tuned on teapot and Cornell box (tests/bench/results).
float nearest_step(float x) {
  constexpr float kToHalfStep = 1.3f, kToPower = 1.62f;
  const auto bits = std::bit_cast<uint32_t>(x);
  const auto power = std::bit_cast<float>(bits & 0x7f800000u);
  const auto ratio = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u);
  return (ratio < kToHalfStep ? 1.0f : ratio < kToPower ? 1.5f : 2.0f) * power;
}

float stepped_share(float rate, float least, float most, float k) {
  return std::min(std::max(least, nearest_step(std::max(0.0f, k * rate))), std::max(least, most));
}

double sum_of_steps(std::span<const float> rates, std::span<const SampleBounds> bounds, float k) {
  return ordered_sum(rates.size(), [&](size_t begin, size_t end) {
    float lanes[kSumLanes] = {};
    const float* rate = rates.data();
    const SampleBounds* bound = bounds.data();
    for_lanes(begin, end, [&](size_t i, size_t lane) {
      lanes[lane] += stepped_share(rate[i], bound[i].least, bound[i].most, k);
    });
    return sum_of_lanes(lanes);
  });
}

// The sum is a step function of K, so Newton's method does not apply: bisects a bracket of K in
// logarithm.
float find_step_scale(std::span<const float> rates, std::span<const SampleBounds> bounds,
                      double total) {
  const Extent extent = extent_of(rates, bounds);
  if (!(extent.most_rate > 0.0f) || !std::isfinite(extent.rates) || total <= extent.least)
    return 0.0f;
  const double highest = std::min(4.0 * double(extent.most_count) / double(extent.least_rate),
                                  0x1p126 / double(extent.most_rate));
  if (total >= extent.most) return float(highest);
  double low = std::min(total / extent.rates, highest), high = low;
  while (sum_of_steps(rates, bounds, float(low)) > total) low /= 2;
  while (high < highest && sum_of_steps(rates, bounds, float(high)) <= total) high *= 2;
  const double close = 1e-3 * total;
  while (high > low * (1 + 1e-4)) {
    const double k = std::sqrt(low * high), sum = sum_of_steps(rates, bounds, float(k));
    (sum <= total ? low : high) = k;
    if (sum <= total && sum > total - close) break;
  }
  return float(low);
}

template <float (*kShareOf)(float rate, float least, float most, float k)>
void set_counts(std::span<const float> rates, std::span<const SampleBounds> bounds, float k,
                std::vector<float>* counts) {
  counts->resize(rates.size());
  constexpr size_t kGrain = 8192;
  parallel_ranges(rates.size(), kGrain, [&](size_t begin, size_t end) {
    float* out = counts->data();
    const float* rate = rates.data();
    const SampleBounds* bound = bounds.data();
    for (size_t i = begin; i < end; ++i) {
      out[i] = kShareOf(rate[i], bound[i].least, bound[i].most, k);
    }
  });
}

}  // namespace

void share_samples(std::span<const float> rates, std::span<const SampleBounds> bounds, double total,
                   std::vector<float>* counts) {
  set_counts<share>(rates, bounds, find_scale(rates, bounds, total), counts);
}

void share_steps(std::span<const float> rates, std::span<const SampleBounds> bounds, double total,
                 std::vector<float>* counts) {
  set_counts<stepped_share>(rates, bounds, find_step_scale(rates, bounds, total), counts);
}

}  // namespace emberline
