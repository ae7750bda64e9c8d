#include "samplers/independent_sampler.h"

#include <cassert>

#include "renderer/core/hash.h"

namespace emberline {

void IndependentSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample,
                              int count, SlotBlock& out, int /*dimensions*/) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  constexpr int kPairs = kSlotDimensions / 2;
  const uint64_t pixel_hash =
      hash_combine64(hash_combine64(pixel.seed, (uint64_t(pixel.y) << 32) | pixel.x), slot);
  uint64_t pair_key[kPairs];
  for (int p = 0; p < kPairs; ++p) pair_key[p] = hash_combine64(pixel_hash, uint64_t(p));

  // The two numbers of a pair are the halves of one 64-bit hash. With 64 bits, no two (sample,
  // pair) in a render are likely to collide.
  const int first_lane = int(first_sample % kSampleLanes);
  for (int i = 0; i < count; ++i) {
    const uint64_t sample_hash = hash64(uint64_t(first_sample) + uint64_t(i) + 1);
    for (int p = 0; p < kPairs; ++p) {
      const uint64_t bits = hash64(pair_key[p] ^ sample_hash);
      out.values[2 * p][first_lane + i] = to_unit_float(uint32_t(bits));
      out.values[2 * p + 1][first_lane + i] = to_unit_float(uint32_t(bits >> 32));
    }
  }
}

}  // namespace emberline
