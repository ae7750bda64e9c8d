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
float scaled_count(float rate, float minimum, float maximum, float k) {
  return std::min(std::max(minimum, k * rate), std::max(minimum, maximum));
}

// Extremes and sums of the rates and bounds, from which the limits of K are computed.
struct Extent {
  float max_rate = 0.0f, min_rate = std::numeric_limits<float>::max(), max_count = 0.0f;
  double rates = 0.0;
  double minimum = 0.0;  // the sum of counts for K = 0
  double maximum = 0.0;  // the sum of counts for K -> infinity

  Extent& operator+=(const Extent& other) {
    max_rate = std::max(max_rate, other.max_rate);
    min_rate = std::min(min_rate, other.min_rate);  // of the positive rates
    max_count = std::max(max_count, other.max_count);
    rates += other.rates;
    minimum += other.minimum;
    maximum += other.maximum;
    return *this;
  }
};

Extent extent_of_part(const float* rates, const SampleBounds* bounds, size_t begin, size_t end) {
  struct Lanes {
    float max_rate[kSumLanes] = {}, max_count[kSumLanes] = {}, min_rate[kSumLanes];
    float rates[kSumLanes] = {}, minimum[kSumLanes] = {}, maximum[kSumLanes] = {};
  } lanes;
  std::ranges::fill(lanes.min_rate, std::numeric_limits<float>::max());
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float rate = std::max(0.0f, rates[i]), minimum = bounds[i].minimum;
    const float maximum = std::max(minimum, bounds[i].maximum);
    const bool grows = rate > 0.0f;
    lanes.max_rate[lane] = std::max(lanes.max_rate[lane], rate);
    lanes.min_rate[lane] = std::min(lanes.min_rate[lane], grows ? rate : 3e38f);
    lanes.max_count[lane] = std::max(lanes.max_count[lane], maximum);
    lanes.rates[lane] += rate;
    lanes.minimum[lane] += minimum;
    lanes.maximum[lane] += grows ? maximum : minimum;
  });
  return {std::ranges::max(lanes.max_rate),  std::ranges::min(lanes.min_rate),
          std::ranges::max(lanes.max_count), sum_of_lanes(lanes.rates),
          sum_of_lanes(lanes.minimum),       sum_of_lanes(lanes.maximum)};
}

Extent extent_of(std::span<const float> rates, std::span<const SampleBounds> bounds) {
  return ordered_sum(rates.size(), [&](size_t begin, size_t end) {
    return extent_of_part(rates.data(), bounds.data(), begin, end);
  });
}

// The sum of all counts for a given K, and its derivative with respect to K. The derivative is the
// sum of the rates of those pixels whose counts are within their bounds.
struct ScaledSum {
  double sum = 0.0, slope = 0.0;
  ScaledSum& operator+=(const ScaledSum& other) {
    sum += other.sum;
    slope += other.slope;
    return *this;
  }
};

ScaledSum scaled_sum_of_part(const float* rates, const SampleBounds* bounds, size_t begin,
                             size_t end, float k) {
  struct Lanes {
    float sum[kSumLanes] = {}, slope[kSumLanes] = {};
  } lanes;
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float wanted = k * rates[i], minimum = bounds[i].minimum, maximum = bounds[i].maximum;
    lanes.sum[lane] += scaled_count(rates[i], minimum, maximum, k);
    lanes.slope[lane] += wanted > minimum && wanted < maximum ? rates[i] : 0.0f;
  });
  return {sum_of_lanes(lanes.sum), sum_of_lanes(lanes.slope)};
}

// Finds the K whose counts add up to `total`. The sum is piecewise linear in K, so Newton's step is
// exact once it stays on one piece. Every fourth step, and any step that leaves the bracket,
// bisects log K instead.
float find_scale(std::span<const float> rates, std::span<const SampleBounds> bounds, double total) {
  const Extent extent = extent_of(rates, bounds);
  if (!(extent.max_rate > 0.0f) || total <= extent.minimum) return 0.0f;
  const double max_count = std::max(1e-3, double(extent.max_count));
  // With this K, even the pixel with the smallest rate reaches its maximum. It is limited to the
  // range of float.
  double high = std::min(2.0 * max_count / double(extent.min_rate), 0x1p126);
  if (total >= extent.maximum) return float(high);
  double low = 0x1p-24 * max_count / double(extent.max_rate);
  double k = std::clamp(total / extent.rates, low, high);
  // Newton's last step corrects the remaining thousandth. Random rounding adds larger errors
  // anyway.
  const double tolerance = 1e-3 * total;
  constexpr int kMaxIterations = 100;
  for (int step = 0; step < kMaxIterations && high > low * (1 + 1e-6); ++step) {
    const ScaledSum scaled = ordered_sum(rates.size(), [&](size_t begin, size_t end) {
      return scaled_sum_of_part(rates.data(), bounds.data(), begin, end, float(k));
    });
    (scaled.sum < total ? low : high) = k;
    const double newton = k + (total - scaled.sum) / scaled.slope;
    const bool inside = newton > low && newton < high;
    if (std::abs(scaled.sum - total) <= tolerance) return float(inside ? newton : k);
    k = inside && step % 4 != 3 ? newton : std::sqrt(low * high);
  }
  return float(k);
}

// Rounds x to a power of two if x is between 1/1.23 and 1.3 times that power, otherwise to 1.5
// times a power of two. Powers of two are favoured because they are better stratified. The limits
// were tuned on the teapot and the Cornell box (tests/bench/results).
float nearest_step(float x) {
  constexpr float kToHalfStep = 1.3f, kToPower = 1.62f;
  const auto bits = std::bit_cast<uint32_t>(x);
  const auto power = std::bit_cast<float>(bits & 0x7f800000u);
  const auto ratio = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u);
  return (ratio < kToHalfStep ? 1.0f : ratio < kToPower ? 1.5f : 2.0f) * power;
}

float stepped_count(float rate, float minimum, float maximum, float k) {
  return std::min(std::max(minimum, nearest_step(std::max(0.0f, k * rate))),
                  std::max(minimum, maximum));
}

double sum_of_steps(std::span<const float> rates, std::span<const SampleBounds> bounds, float k) {
  return ordered_sum(rates.size(), [&](size_t begin, size_t end) {
    float lanes[kSumLanes] = {};
    const float* rate = rates.data();
    const SampleBounds* bound = bounds.data();
    for_lanes(begin, end, [&](size_t i, size_t lane) {
      lanes[lane] += stepped_count(rate[i], bound[i].minimum, bound[i].maximum, k);
    });
    return sum_of_lanes(lanes);
  });
}

// Finds K by bisecting log K. Newton's method does not apply, because the sum is a step function of
// K.
float find_step_scale(std::span<const float> rates, std::span<const SampleBounds> bounds,
                      double total) {
  const Extent extent = extent_of(rates, bounds);
  if (!(extent.max_rate > 0.0f) || !std::isfinite(extent.rates) || total <= extent.minimum)
    return 0.0f;
  const double highest = std::min(4.0 * double(extent.max_count) / double(extent.min_rate),
                                  0x1p126 / double(extent.max_rate));
  if (total >= extent.maximum) return float(highest);
  double low = std::min(total / extent.rates, highest), high = low;
  while (sum_of_steps(rates, bounds, float(low)) > total) low /= 2;
  while (high < highest && sum_of_steps(rates, bounds, float(high)) <= total) high *= 2;
  const double tolerance = 1e-3 * total;
  while (high > low * (1 + 1e-4)) {
    const double k = std::sqrt(low * high), sum = sum_of_steps(rates, bounds, float(k));
    (sum <= total ? low : high) = k;
    if (sum <= total && sum > total - tolerance) break;
  }
  return float(low);
}

template <float (*kCountOf)(float rate, float minimum, float maximum, float k)>
void set_counts(std::span<const float> rates, std::span<const SampleBounds> bounds, float k,
                std::vector<float>* counts) {
  counts->resize(rates.size());
  constexpr size_t kGrain = 8192;
  parallel_ranges(rates.size(), kGrain, [&](size_t begin, size_t end) {
    float* out = counts->data();
    const float* rate = rates.data();
    const SampleBounds* bound = bounds.data();
    for (size_t i = begin; i < end; ++i) {
      out[i] = kCountOf(rate[i], bound[i].minimum, bound[i].maximum, k);
    }
  });
}

}  // namespace

void allocate_samples(std::span<const float> rates, std::span<const SampleBounds> bounds,
                      double total, std::vector<float>* counts) {
  set_counts<scaled_count>(rates, bounds, find_scale(rates, bounds, total), counts);
}

void allocate_steps(std::span<const float> rates, std::span<const SampleBounds> bounds,
                    double total, std::vector<float>* counts) {
  set_counts<stepped_count>(rates, bounds, find_step_scale(rates, bounds, total), counts);
}

}  // namespace emberline
