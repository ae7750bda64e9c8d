// How a round's samples are shared out. Pure functions of the pixels' state.
//
// The best share of a budget of time is n ~ deviation / sqrt(cost) (Neyman 1934, "On the Two
// Different Aspects of the Representative Method", with costs): it makes the sum of variance / n
// least for a given sum of n x cost. What is asked here as well: no pixel loses samples it has,
// none is left out for good, none is trusted with more than its present samples can vouch for.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace emberline {

// One pixel's bounds for the coming round: it may have from `least` to `most` samples after it.
struct SampleBounds {
  float least = 0.0f, most = 0.0f;
};

// Counts n_i = clamp(K x rate_i, least_i, most_i) with K such that their sum is `total`, or all at
// `most` if that is less than the total, or all at `least` if that is more. Rates are >= 0 and
// finite; one that is no number counts as 0. In parallel, with the same result whatever the
// threads.
void share_samples(std::span<const float> rates, std::span<const SampleBounds> bounds, double total,
                   std::vector<float>* counts);

// The same with each K x rate_i rounded to a power of two or one and a half times one, whichever is
// near in ratio, and with the largest such K whose counts sum to no more than `total` (to a part in
// ten thousand of K). A pixel so goes from one such count n to the next, m, once what that is
// expected to bring for its samples, variance / (n m), is worth about as much as everybody else's.
void share_steps(std::span<const float> rates, std::span<const SampleBounds> bounds, double total,
                 std::vector<float>* counts);

// Counts are multiples of this. Whole blocks of the sampler: pairs of dimensions are stratified by
// 8, streams alternate by 8. Of many samples, a quarter of the power of two below: what a Sobol'
// sequence has at 12, 14 or 16 times a power of two is better stratified than in between
// (tests/bench/results). Where a pixel is judged by the halves of its samples, a half of it: at
// other counts it is not looked at again.
inline uint32_t count_multiple(float wanted, bool halves) {
  const uint32_t steps = halves ? 2 : 4;
  return std::max(8u, std::bit_floor(uint32_t(std::min(wanted, 16777216.0f))) / steps);
}

// Rounds `wanted` up or down by chance (u in [0, 1)), so that its expectation is kept, to `have` or
// a multiple of `step`, a power of two, above it; to `have` if less is wanted, or NaN. Exact below
// 2^24, in floats throughout so that loops vectorise.
inline uint32_t round_count(uint32_t have, float wanted, uint32_t step, float u) {
  const auto least = float(have), whole_step = float(step);
  const float lower = std::max(least, std::floor(wanted / whole_step) * whole_step);
  const float upper = (std::floor(lower / whole_step) + 1.0f) * whole_step;
  const float rounded = u * (upper - lower) < wanted - lower ? upper : lower;
  return wanted > least ? uint32_t(rounded) : have;
}

}  // namespace emberline
