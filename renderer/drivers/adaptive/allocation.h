// Functions that distribute a round's samples. They are pure functions of the pixels' state.
//
// The best distribution of a time budget is n ~ deviation / sqrt(cost) (Neyman 1934, "On the Two
// Different Aspects of the Representative Method", extended to samples of different cost). It
// minimizes the sum of variance / n for a given sum of n x cost. In addition, no pixel loses
// samples, no pixel is left out forever, and no pixel's count grows further than its present
// samples justify.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace emberline {

// Bounds of a pixel's sample count after the coming round.
struct SampleBounds {
  float minimum = 0.0f, maximum = 0.0f;
};

// Computes counts n_i = clamp(K x rate_i, minimum_i, maximum_i). K is such that the counts add up
// to `total`. If the maxima add up to less than `total`, all counts are maxima; if the minima add
// up to more, all counts are minima. Rates must be >= 0 and finite; NaN counts as 0. Runs in
// parallel, with the same result for any number of threads.
void allocate_samples(std::span<const float> rates, std::span<const SampleBounds> bounds,
                      double total, std::vector<float>* counts);

// Like allocate_samples(), but K x rate_i is rounded to a power of two or 1.5 times a power of two,
// with a preference for powers of two. K is about the largest value for which the counts add up to
// at most `total`. A step from n to m samples reduces the squared error by variance / (n m) per
// sample. All pixels take their next step at about the same value of this gain.
void allocate_steps(std::span<const float> rates, std::span<const SampleBounds> bounds,
                    double total, std::vector<float>* counts);

// Returns the step for rounding a count near `wanted`: the count must be a multiple of it. The step
// is at least 8, one block of the sampler: pairs of dimensions are stratified in blocks of 8
// samples, and streams alternate every 8. For large counts it is a quarter of the largest power of
// two that is at most `wanted`, because a Sobol' sequence is better stratified at 12, 14 or 16
// times a power of two than in between (tests/bench/results). With `halves` the step is half of
// that power of two, because a pixel's halves are compared only at multiples of it.
inline uint32_t count_multiple(float wanted, bool halves) {
  const uint32_t steps = halves ? 2 : 4;
  return std::max(8u, std::bit_floor(uint32_t(std::min(wanted, 16777216.0f))) / steps);
}

// Rounds `wanted` to `current` or to a larger multiple of `step`, which must be a power of two. The
// random number u in [0, 1) decides whether to round up or down, so that the expectation is
// `wanted`. Returns `current` if `wanted` is less than `current` or NaN. Exact below 2^24; uses
// only floats so that loops vectorise.
inline uint32_t round_count(uint32_t current, float wanted, uint32_t step, float u) {
  const auto minimum = float(current), whole_step = float(step);
  const float lower = std::max(minimum, std::floor(wanted / whole_step) * whole_step);
  const float upper = (std::floor(lower / whole_step) + 1.0f) * whole_step;
  const float rounded = u * (upper - lower) < wanted - lower ? upper : lower;
  return wanted > minimum ? uint32_t(rounded) : current;
}

}  // namespace emberline
