// A discrete distribution as a running sum of 32-bit fixed point, with Chen & Asau's guide table.
//
// The probability of an entry is the exact difference of two integers, so that what is drawn and
// what is claimed agree to the last bit, in one word per entry: a float running sum keeps no
// weights of its own (differences cancel), and a float weight keeps no exact sum (a 16k x 8k map's
// is off by a third when it is accumulated in float). An entry of positive weight, however small,
// keeps at least one step of 2^-32, so density is positive wherever weight is.
//
// Guide table: Chen & Asau 1974, "On Generating Random Variates from an Empirical Distribution".
// Unlike an alias table it is monotone in u and keeps stratified numbers stratified.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace emberline {

inline constexpr uint32_t kCdfTotal =
    0xffffffffu;  // the last running sum, unless all weights are 0

struct CdfChoice {
  uint32_t index = 0;
  float remainder = 0.0f;  // where in the entry's share u lies, [0, 1)
};

// Guide cells for a distribution of `count` entries; the table has one more word than cells.
// One cell per 16 entries: a search of at most four steps where weights are even.
inline int guide_bits(size_t count) {
  int bits = 0;
  while ((size_t(16) << bits) < count) ++bits;
  return bits;
}
inline size_t guide_words(size_t count) { return (size_t(1) << guide_bits(count)) + 1; }

// Fills `sums` (weights.size() + 1 words, first 0) and `guide` (guide_words). Weights are finite
// and not negative. All 0: every sum is 0, and choose_entry must not be called.
void build_fixed_cdf(std::span<const double> weights, uint32_t* sums, uint32_t* guide);

inline uint32_t guide_cell(int bits, float u) {
  return uint32_t(uint64_t(uint32_t(double(u) * double(kCdfTotal))) >> (32 - bits));
}

// For those who choose from many large distributions at once: asks for the memory that
// choose_entry will wait for, first the guide's, and when that is there the sums'.
inline void prefetch_guide(const uint32_t* guide, int bits, float u) {
  __builtin_prefetch(guide + guide_cell(bits, u));
}
inline void prefetch_sums(const uint32_t* sums, const uint32_t* guide, int bits, float u) {
  const uint32_t cell = guide_cell(bits, u);
  const uint32_t low = guide[cell], high = guide[cell + 1];
  __builtin_prefetch(sums + low);
  __builtin_prefetch(sums + low + (high - low + 1) / 2);
}

// u in [0, 1). The entry whose share of [0, 1) holds u, which is never an empty one.
inline CdfChoice choose_entry(const uint32_t* sums, const uint32_t* guide, int bits, float u) {
  const double x = double(u) * double(kCdfTotal);
  const uint32_t whole = uint32_t(x);
  const uint32_t cell = guide_cell(bits, u);
  // The last entry that begins at or before x, by halves whose side is computed, not branched to:
  // a random number's way cannot be predicted.
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
