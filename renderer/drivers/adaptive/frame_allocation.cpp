#include "renderer/drivers/adaptive/frame_allocation.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/core/hash.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/allocation.h"
#include "renderer/drivers/adaptive/pixel_statistics.h"

namespace emberline {

float jitter_rate(float rate, uint32_t seed, size_t i) {
  constexpr float kSpread = 1.0f / 16;
  return rate * (1.0f + kSpread * to_unit_float(hash_combine(seed, uint32_t(i))));
}

namespace {

// A planned count is at least 1 / kMinPlannedFraction of the mean count, since pixels that look
// free of noise may have missed rare light. Beyond that, it is at most kMaxPlannedGrowth times the
// samples on which the plan is based.
constexpr uint32_t kMinPlannedFraction = 8;
constexpr float kMaxPlannedGrowth = 16.0f;

constexpr size_t kFrameGrain = 8192;

// Returns the least multiple of `step` that is at least `count`.
float round_up(float count, uint32_t step) { return std::ceil(count / float(step)) * float(step); }

// Distributes the whole budget of `limits` at once. Each count is at least `least_of(i)`. Beyond
// that, it is at most `max_growth` times the count on which the errors are based, and at most what
// the threshold needs. No count exceeds sample_limit().
template <typename LeastOf>
std::vector<float> allocate_anew(const FrameEstimates& known, const AdaptiveSettings& limits,
                                 float max_growth, const LeastOf& least_of) {
  const auto& [statistics, errors, seed] = known;
  const size_t pixels = errors.error.size();
  const float limit = sample_limit(limits);
  std::vector<float> rates(pixels), counts;
  std::vector<SampleBounds> bounds(pixels);
  parallel_ranges(pixels, kFrameGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float current = statistics.count[i];
      float most = max_growth * current;
      if (limits.threshold > 0.0f) {
        const float ratio = std::min(errors.error[i] / limits.threshold, 1e6f);
        const float wanted = std::min(most, current * ratio * ratio * kThresholdMargin);
        most = round_up(wanted, count_multiple(wanted, false));
      }
      const float least = std::min(least_of(i), limit);
      bounds[i] = {least, std::min(std::max(least, most), limit)};
      rates[i] = jitter_rate(errors.deviation[i] / std::sqrt(statistics.cost[i]), seed, i);
    }
  });
  // If no pixel has shown noise, all get the same rate, because they may still be noisy.
  if (std::ranges::none_of(rates, [](float rate) { return rate > 0.0f; })) {
    for (size_t i = 0; i < pixels; ++i) rates[i] = jitter_rate(1.0f, seed, i);
  }
  const double budget = limits.budget > 0 ? double(limits.budget) : kUnlimited;
  allocate_steps(rates, bounds, budget * double(pixels), &counts);
  return counts;
}

}  // namespace

std::vector<uint32_t> allocate_frame(const FrameEstimates& known, const AdaptiveSettings& limits) {
  // With fewer than kMaxPilot samples, the film's second half would have no samples.
  uint32_t least = std::max(limits.two_halves ? kMaxPilot : kMinPilot,
                            std::bit_floor(limits.budget / kMinPlannedFraction));
  if (limits.budget > 0) least = std::min(least, limits.budget);
  least = std::max(least, limits.min_samples);
  const std::vector<float> counts =
      allocate_anew(known, limits, kMaxPlannedGrowth, [least](size_t) { return float(least); });
  return {counts.begin(), counts.end()};  // all counts are whole numbers
}

WorkForecast predict_work(const FrameEstimates& known, const AdaptiveSettings& limits,
                          std::span<const uint32_t> current) {
  const std::vector<float> counts = allocate_anew(known, limits, sample_limit(limits),
                                                  [&](size_t i) { return float(current[i]); });
  double samples = 0, work = 0, done = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    samples += double(counts[i]);
    work += double(counts[i]) * double(known.pixels.cost[i]);
    done += double(current[i]) * double(known.pixels.cost[i]);
  }
  return {samples, work / done};
}

}  // namespace emberline
