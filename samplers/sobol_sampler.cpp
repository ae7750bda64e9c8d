#include "samplers/sobol_sampler.h"

#include <array>
#include <cassert>

#include "renderer/core/hash.h"
#include "samplers/owen_sobol.h"

namespace emberline {
namespace {

constexpr int kPairs = kSlotDimensions / 2;
constexpr int kBlock = 8;  // indices permuted at random among themselves; see README.md for why 8
constexpr uint32_t kNaturalOrder = 0x76543210u;

// Well-mixed words that tell apart the uses of one slot's hash.
template <int kCount>
constexpr std::array<uint32_t, kCount> salts(uint32_t first) {
  std::array<uint32_t, kCount> result{};
  for (int i = 0; i < kCount; ++i) result[i] = hash_combine(0x50b01u, first + uint32_t(i));
  return result;
}
constexpr std::array<uint32_t, kSlotDimensions> kScrambleSalt = salts<kSlotDimensions>(0);
constexpr std::array<uint32_t, kPairs> kShuffleSalt = salts<kPairs>(0x100);
constexpr std::array<uint32_t, kPairs> kOrderSalt = salts<kPairs>(0x200);

// What the eight samples of one block of a stream have in common.
struct BlockPlan {
  uint32_t scramble[kSlotDimensions];  // Owen scramble of each dimension: one per stream and slot
  uint32_t base[kPairs];               // the shuffled block's first index
  uint32_t order[kPairs];              // the order within it, as packed nibbles
};

BlockPlan plan_block(uint32_t stream_hash, uint32_t slot, uint32_t block) {
  BlockPlan plan;
  const uint32_t slot_hash = hash_combine(stream_hash, slot);
  const uint32_t block_hash = hash32(block + 0x9e3779b9u);
  for (int d = 0; d < kSlotDimensions; ++d) {
    plan.scramble[d] = hash32(slot_hash ^ kScrambleSalt[d]);
  }
  for (int p = 0; p < kPairs; ++p) {
    const uint32_t shuffle = hash32(slot_hash ^ kShuffleSalt[p]);
    plan.base[p] = owen_sobol::shuffle_index(block * kBlock, shuffle) & ~uint32_t(kBlock - 1);
    plan.order[p] =
        owen_sobol::random_order_of_8(hash32(hash32(slot_hash ^ kOrderSalt[p]) ^ block_hash));
  }
  if (slot == 0) {
    plan.base[0] = block * kBlock;
    plan.order[0] = kNaturalOrder;
  }
  return plan;
}

// All eight samples of a block; the inner loops vectorise (8 lanes of 32 bits).
void fill_block(const BlockPlan& plan, int first_lane, SlotBlock& out) {
  for (int p = 0; p < kPairs; ++p) {
    const uint32_t base = plan.base[p];
    const uint32_t pascal_base = owen_sobol::pascal(base);
    const uint32_t order = plan.order[p];
    const uint32_t seed_x = plan.scramble[2 * p];
    const uint32_t seed_y = plan.scramble[2 * p + 1];
    float* x = out.values[2 * p] + first_lane;
    float* y = out.values[2 * p + 1] + first_lane;
    for (uint32_t i = 0; i < kBlock; ++i) {
      const uint32_t within = (order >> (4 * i)) & 7u;
      const uint32_t index_y = pascal_base ^ owen_sobol::pascal_below_8(within);
      x[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(base | within, seed_x));
      y[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(index_y, seed_y));
    }
  }
}

// One sample; here the loop over dimensions is the one that vectorises.
void fill_one(const BlockPlan& plan, uint32_t index_in_block, int lane, SlotBlock& out) {
  uint32_t index[kSlotDimensions];
  for (int p = 0; p < kPairs; ++p) {
    const uint32_t i = plan.base[p] | ((plan.order[p] >> (4 * index_in_block)) & 7u);
    index[2 * p] = i;
    index[2 * p + 1] = owen_sobol::pascal(i);
  }
  for (int d = 0; d < kSlotDimensions; ++d) {
    out.values[d][lane] =
        owen_sobol::reversed_to_unit_float(owen_sobol::permute(index[d], plan.scramble[d]));
  }
}

}  // namespace

void SobolSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count,
                        SlotBlock& out) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  const uint32_t pixel_hash = hash_combine(hash_combine(hash32(pixel.seed), pixel.x), pixel.y);
  const uint32_t last_sample = first_sample + uint32_t(count) - 1;
  // At most two blocks of 8 samples: with two streams they are one block of each.
  for (uint32_t half = first_sample / kBlock; half <= last_sample / kBlock; ++half) {
    const bool two = streams_ == StreamCount::kTwo;
    const uint32_t stream = two ? half & 1u : 0u;
    const uint32_t block = two ? half >> 1 : half;
    const BlockPlan plan = plan_block(hash_combine(pixel_hash, stream), slot, block);
    const int first_lane = int(half * kBlock % kSampleLanes);
    const uint32_t begin = half == first_sample / kBlock ? first_sample % kBlock : 0;
    const uint32_t end = half == last_sample / kBlock ? last_sample % kBlock + 1 : kBlock;
    if (end - begin == kBlock) {
      fill_block(plan, first_lane, out);
    } else {
      for (uint32_t i = begin; i < end; ++i) fill_one(plan, i, first_lane + int(i), out);
    }
  }
}

}  // namespace emberline
