// A discrete distribution, stored as running sums in 32-bit fixed point with a guide table.
//
// The probability of an entry is the exact difference of two integers, so an entry is sampled with
// exactly the reported probability. Each entry needs only one word. With float running sums,
// differences would lose precision, and even the total would be inexact (off by a third for a 16k x
// 8k map). An entry of positive weight, however small, gets at least one step of 2^-32, so its
// density is positive.
//
// The guide table follows Chen & Asau 1974, "On Generating Random Variates from an Empirical
// Distribution". The chosen entry is monotone in u, so stratified numbers stay stratified. With an
// alias table, it would not be monotone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace emberline {

// The last running sum, unless all weights are 0.
inline constexpr uint32_t kCdfTotal = 0xffffffffu;

struct CdfChoice {
  uint32_t index = 0;
  float remainder = 0.0f;  // position of u within the entry, in [0, 1)
};

// Returns log2 of the number of guide cells for `count` entries. The guide table has one word more
// than there are cells. There is one cell per 16 entries, so a search takes at most four steps if
// the weights are equal.
inline int guide_bits(size_t count) {
  int bits = 0;
  while ((size_t(16) << bits) < count) ++bits;
  return bits;
}
inline size_t guide_words(size_t count) { return (size_t(1) << guide_bits(count)) + 1; }

// Fills `sums` (weights.size() + 1 words, of which the first is 0) and `guide`
// (guide_words(weights.size()) words). Weights must be finite and not negative. If all weights are
// 0, every sum is 0, and choose_entry() must not be called.
void build_fixed_cdf(std::span<const double> weights, uint32_t* sums, uint32_t* guide);

inline uint32_t guide_cell(int bits, float u) {
  return uint32_t(uint64_t(uint32_t(double(u) * double(kCdfTotal))) >> (32 - bits));
}

// These functions prefetch the memory that choose_entry() reads, for choices from many large
// distributions at once. Call prefetch_guide() for all distributions first, since prefetch_sums()
// reads the guide.
inline void prefetch_guide(const uint32_t* guide, int bits, float u) {
  __builtin_prefetch(guide + guide_cell(bits, u));
}
inline void prefetch_sums(const uint32_t* sums, const uint32_t* guide, int bits, float u) {
  const uint32_t cell = guide_cell(bits, u);
  const uint32_t low = guide[cell], high = guide[cell + 1];
  __builtin_prefetch(sums + low);
  __builtin_prefetch(sums + low + (high - low + 1) / 2);
}

// Returns the entry whose interval of [0, 1) contains u in [0, 1); never an entry of probability 0.
inline CdfChoice choose_entry(const uint32_t* sums, const uint32_t* guide, int bits, float u) {
  const double x = double(u) * double(kCdfTotal);
  const uint32_t whole = uint32_t(x);
  const uint32_t cell = guide_cell(bits, u);
  // Binary search for the last entry that begins at or before x. The search is branch-free, since
  // branches on a random number cannot be predicted.
  uint32_t low = guide[cell];
  for (uint32_t left = guide[cell + 1] - low + 1; left > 1;) {
    const uint32_t half = left / 2;
    low += half & (0u - uint32_t(sums[low + half] <= whole));
    left -= half;
  }
  const uint32_t begin = sums[low];
  const double share = double(sums[low + 1] - begin);
  const float remainder = float((x - double(begin)) / share);
  return {low, remainder < 1.0f ? remainder : 0x1.fffffep-1f};
}

}  // namespace emberline
