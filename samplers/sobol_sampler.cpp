#include "samplers/sobol_sampler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <optional>

#include "renderer/core/hash.h"
#include "samplers/owen_sobol.h"

namespace emberline {
namespace {

// Number of consecutive indices that are permuted at random among themselves (sobol_sampler.h).
constexpr uint32_t kBlockSize = 8;

using owen_sobol::Order;

// Returns the index order of a pair, or nothing if the pair has a random order. The light and BSDF
// samples of one surface share an order, since their contributions add. Pairs whose effects
// multiply must not share an order, or one pair would be a copy of the other.
constexpr std::optional<Order> order_of(uint32_t slot, int pair) {
  if (slot == 0) {
    if (pair == 0) return Order::kPixel;
    if (pair == 1) return Order::kLens;
  } else if (slot == 1) {
    if (pair < 2) return Order::kFirst;
    if (pair == 2) return Order::kChoice;
  } else if (slot == 2 && pair < 2) {
    return Order::kSecond;
  }
  return std::nullopt;
}
// The result of apply_order_to_8() for each order.
constexpr std::array<uint32_t, owen_sobol::kOrders> kOrdered8 = [] {
  std::array<uint32_t, owen_sobol::kOrders> result{};
  for (size_t o = 0; o < result.size(); ++o) result[o] = owen_sobol::apply_order_to_8(Order(o));
  return result;
}();

// Well-mixed words that separate the different uses of a slot's hash.
template <int kCount>
constexpr std::array<uint32_t, kCount> salts(uint32_t first) {
  std::array<uint32_t, kCount> result{};
  for (int i = 0; i < kCount; ++i) result[i] = hash_combine(0x50b01u, first + uint32_t(i));
  return result;
}
constexpr std::array<uint32_t, kSlotDimensions> kScrambleSalt = salts<kSlotDimensions>(0);
constexpr std::array<uint32_t, kSlotDimensions / 2> kShuffleSalt =
    salts<kSlotDimensions / 2>(0x100);
constexpr std::array<uint32_t, kSlotDimensions / 2> kOrderSalt = salts<kSlotDimensions / 2>(0x200);

// Data that the eight samples of a stream's block share, for one or two blocks and the first kPairs
// pairs of dimensions. The data of block b is at [b * kDimensions + d] for dimension d and at
// [b * kPairs + p] for pair p, so that the loops vectorise.
template <int kBlocks, int kPairs>
struct BlockPlan {
  static constexpr int kDimensions = 2 * kPairs;
  alignas(64) uint32_t scramble[kBlocks * kDimensions];  // Owen scramble of each dimension
  // A sample's index in a pair's sequence is its block's `base` xor the sample's nibble of `order`.
  alignas(64) uint32_t base[kBlocks * kPairs];
  alignas(64) uint32_t order[kBlocks * kPairs];
};

struct Block {
  uint32_t stream_hash;
  uint32_t index;  // within the stream
};

template <int kPairs, int kBlocks>
BlockPlan<kBlocks, kPairs> plan_blocks(const Block (&blocks)[kBlocks], uint32_t slot) {
  constexpr int kDimensions = 2 * kPairs;
  BlockPlan<kBlocks, kPairs> plan;
  alignas(64) uint32_t scramble_key[kBlocks * kDimensions];
  alignas(64) uint32_t shuffle_key[kBlocks * kPairs];
  alignas(64) uint32_t order_key[kBlocks * kPairs];
  alignas(64) uint32_t block_hash[kBlocks * kPairs];
  alignas(64) uint32_t first_index[kBlocks * kPairs];
  for (int b = 0; b < kBlocks; ++b) {
    const uint32_t slot_hash = hash_combine(blocks[b].stream_hash, slot);
    for (int d = 0; d < kDimensions; ++d) {
      scramble_key[b * kDimensions + d] = slot_hash ^ kScrambleSalt[d];
    }
    for (int p = 0; p < kPairs; ++p) {
      shuffle_key[b * kPairs + p] = slot_hash ^ kShuffleSalt[p];
      order_key[b * kPairs + p] = slot_hash ^ kOrderSalt[p];
      block_hash[b * kPairs + p] = blocks[b].index;
      first_index[b * kPairs + p] = blocks[b].index * kBlockSize;
    }
  }
  for (int i = 0; i < kBlocks * kDimensions; ++i) plan.scramble[i] = hash32(scramble_key[i]);
  for (int i = 0; i < kBlocks * kPairs; ++i) {
    plan.base[i] = owen_sobol::shuffle_index(first_index[i], hash32(shuffle_key[i])) &
                   ~uint32_t(kBlockSize - 1);
    plan.order[i] = owen_sobol::random_order_of_8(
        hash32(hash32(order_key[i]) ^ hash32(block_hash[i] + 0x9e3779b9u)));
  }
  for (int p = 0; p < kPairs; ++p) {
    const std::optional<Order> order = order_of(slot, p);
    if (!order) continue;
    for (int b = 0; b < kBlocks; ++b) {
      plan.base[b * kPairs + p] = owen_sobol::apply_order(first_index[b * kPairs + p], *order);
      plan.order[b * kPairs + p] = kOrdered8[size_t(*order)];
    }
  }
  return plan;
}

// Fills whole blocks. The inner loop vectorises (8 lanes of 32 bits).
template <int kBlocks, int kPairs>
void fill_blocks(const BlockPlan<kBlocks, kPairs>& plan, int first_lane, SlotBlock& out) {
  for (int b = 0; b < kBlocks; ++b) {
    for (int p = 0; p < kPairs; ++p) {
      const uint32_t base = plan.base[b * kPairs + p];
      const uint32_t pascal_base = owen_sobol::pascal(base);
      const uint32_t order = plan.order[b * kPairs + p];
      const uint32_t seed_x = plan.scramble[b * plan.kDimensions + 2 * p];
      const uint32_t seed_y = plan.scramble[b * plan.kDimensions + 2 * p + 1];
      float* x = out.values[2 * p] + first_lane + b * kBlockSize;
      float* y = out.values[2 * p + 1] + first_lane + b * kBlockSize;
      for (uint32_t i = 0; i < kBlockSize; ++i) {
        const uint32_t within = (order >> (4 * i)) & 7u;
        const uint32_t index_y = pascal_base ^ owen_sobol::pascal_below_8(within);
        x[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(base ^ within, seed_x));
        y[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(index_y, seed_y));
      }
    }
  }
}

// Fills one sample. Here the loop over dimensions vectorises.
template <int kPairs>
void fill_one(const BlockPlan<1, kPairs>& plan, uint32_t index_in_block, int lane, SlotBlock& out) {
  constexpr int kDimensions = 2 * kPairs;
  alignas(32) uint32_t index[kDimensions];
  alignas(32) float values[kDimensions];
  for (int p = 0; p < kPairs; ++p) {
    const uint32_t i = plan.base[p] ^ ((plan.order[p] >> (4 * index_in_block)) & 7u);
    index[2 * p] = i;
    index[2 * p + 1] = owen_sobol::pascal(i);
  }
#pragma GCC unroll 1  // fully unrolled, the loop would no longer vectorise
  for (int d = 0; d < kDimensions; ++d) {
    values[d] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(index[d], plan.scramble[d]));
  }
  for (int d = 0; d < kDimensions; ++d) out.values[d][lane] = values[d];
}

// Fills the first kPairs pairs of a slot.
template <int kPairs, class BlockOf>
void fill_pairs(const BlockOf& block_of, uint32_t slot, uint32_t first_sample, int count,
                SlotBlock& out) {
  const uint32_t first_half = first_sample / kBlockSize;
  if (count == kSampleLanes) {
    const Block blocks[] = {block_of(first_half), block_of(first_half + 1)};
    fill_blocks(plan_blocks<kPairs>(blocks, slot), 0, out);
    return;
  }
  const uint32_t last_sample = first_sample + uint32_t(count) - 1;
  for (uint32_t half = first_half; half <= last_sample / kBlockSize; ++half) {
    const Block blocks[] = {block_of(half)};
    const BlockPlan<1, kPairs> plan = plan_blocks<kPairs>(blocks, slot);
    const int first_lane = int(half * kBlockSize % kSampleLanes);
    const uint32_t begin = half == first_half ? first_sample % kBlockSize : 0;
    const uint32_t end =
        half == last_sample / kBlockSize ? last_sample % kBlockSize + 1 : kBlockSize;
    if (end - begin == kBlockSize) {
      fill_blocks(plan, first_lane, out);
    } else {
      for (uint32_t i = begin; i < end; ++i) fill_one(plan, i, first_lane + int(i), out);
    }
  }
}

template <int kBlocks>
void fill_whole(const Block (&blocks)[kBlocks], uint32_t slot, int first_lane, SlotBlock& out,
                int dimensions) {
  if (dimensions <= 2) {
    fill_blocks(plan_blocks<1>(blocks, slot), first_lane, out);
  } else {
    fill_blocks(plan_blocks<kSlotDimensions / 2>(blocks, slot), first_lane, out);
  }
}

// Whether the eight samples from `samples` on are one whole block of a pixel, in order.
bool is_whole_block(const SampleAddress* samples) {
  const SampleAddress& first = samples[0];
  uint32_t different = first.sample % kBlockSize;
  for (uint32_t i = 0; i < kBlockSize; ++i) {
    const SampleAddress& a = samples[i];
    different |= (a.x ^ first.x) | (a.y ^ first.y) | (a.sample ^ (first.sample + i));
  }
  return different == 0;
}

// Sixteen samples of any pixels. Each has its own stream and block.
struct ScatteredLanes {
  alignas(64) uint32_t stream_hash[kSampleLanes];
  alignas(64) uint32_t block[kSampleLanes];     // index within the stream
  alignas(64) uint32_t in_block[kSampleLanes];  // index within the block's eight samples
};

// Computes apply_order() for the first index of each lane's block.
void order_blocks(const ScatteredLanes& lanes, Order order, uint32_t (&base)[kSampleLanes]) {
  const owen_sobol::OrderColumns& columns = owen_sobol::kOrderColumns[size_t(order)];
  uint32_t bits = 0;
  for (int i = 0; i < kSampleLanes; ++i) {
    bits |= lanes.block[i] * kBlockSize;
    base[i] = 0;
  }
  for (; bits != 0; bits &= bits - 1) {
    const int bit = std::countr_zero(bits);
    for (int i = 0; i < kSampleLanes; ++i) {
      base[i] ^= columns[size_t(bit)] & (0u - ((lanes.block[i] * kBlockSize >> bit) & 1u));
    }
  }
}

// Computes one pair of dimensions of a slot. The values are the same as those of plan_blocks() and
// fill_blocks(). The loops vectorise over the lanes.
void fill_scattered_pair(const ScatteredLanes& lanes, uint32_t slot, int pair,
                         float (&x)[kSampleLanes], float (&y)[kSampleLanes]) {
  alignas(64) uint32_t base[kSampleLanes], order[kSampleLanes];
  if (const std::optional<Order> fixed = order_of(slot, pair)) {
    order_blocks(lanes, *fixed, base);
    std::fill(order, order + kSampleLanes, kOrdered8[size_t(*fixed)]);
  } else {
    const uint32_t shuffle_salt = kShuffleSalt[size_t(pair)], order_salt = kOrderSalt[size_t(pair)];
    for (int i = 0; i < kSampleLanes; ++i) {
      const uint32_t slot_hash = hash_combine(lanes.stream_hash[i], slot);
      base[i] =
          owen_sobol::shuffle_index(lanes.block[i] * kBlockSize, hash32(slot_hash ^ shuffle_salt)) &
          ~(kBlockSize - 1);
      order[i] = owen_sobol::random_order_of_8(
          hash32(hash32(slot_hash ^ order_salt) ^ hash32(lanes.block[i] + 0x9e3779b9u)));
    }
  }
  const uint32_t salt_x = kScrambleSalt[size_t(2 * pair)];
  const uint32_t salt_y = kScrambleSalt[size_t(2 * pair + 1)];
  for (int i = 0; i < kSampleLanes; ++i) {
    const uint32_t slot_hash = hash_combine(lanes.stream_hash[i], slot);
    const uint32_t index = base[i] ^ ((order[i] >> (4 * lanes.in_block[i])) & 7u);
    const uint32_t seed_x = hash32(slot_hash ^ salt_x), seed_y = hash32(slot_hash ^ salt_y);
    x[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(index, seed_x));
    y[i] =
        owen_sobol::reversed_to_unit_float(owen_sobol::permute(owen_sobol::pascal(index), seed_y));
  }
}

// The block that holds samples 8 * half to 8 * half + 7 of a pixel. Example: with two streams,
// samples 40..47 are half 5, which is block 2 of stream 1.
Block block_of(uint32_t pixel_hash, uint32_t half, StreamCount streams) {
  if (streams == StreamCount::kOne) return {hash_combine(pixel_hash, 0), half};
  return {hash_combine(pixel_hash, half & 1u), half >> 1};
}

// Writes the time of camera samples, in an order that stratifies it jointly with the pixel
// position, because motion couples the two.
void fill_time(const ScatteredLanes& lanes, int count, float* time) {
  alignas(64) uint32_t base[kSampleLanes];
  order_blocks(lanes, Order::kTime, base);
  alignas(64) float values[kSampleLanes];
  for (int i = 0; i < kSampleLanes; ++i) {
    const uint32_t seed =
        hash32(hash_combine(lanes.stream_hash[i], 0) ^ kScrambleSalt[camera_dim::kTime]);
    const uint32_t index =
        base[i] ^ ((kOrdered8[size_t(Order::kTime)] >> (4 * lanes.in_block[i])) & 7u);
    values[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(index, seed));
  }
  std::copy_n(values, count, time);
}

ScatteredLanes lanes_of(std::span<const SampleAddress> samples, uint32_t seed,
                        StreamCount streams) {
  const uint32_t seed_hash = hash32(seed);
  alignas(64) uint32_t x[kSampleLanes] = {}, y[kSampleLanes] = {}, half[kSampleLanes] = {};
  ScatteredLanes lanes;
  for (size_t i = 0; i < samples.size(); ++i) {
    x[i] = samples[i].x;
    y[i] = samples[i].y;
    half[i] = samples[i].sample / kBlockSize;
    lanes.in_block[i] = samples[i].sample % kBlockSize;
  }
  for (size_t i = samples.size(); i < size_t(kSampleLanes); ++i) lanes.in_block[i] = 0;
  const uint32_t second = streams == StreamCount::kTwo ? 1 : 0;
  for (int i = 0; i < kSampleLanes; ++i) {
    const uint32_t pixel_hash = hash_combine(hash_combine(seed_hash, x[i]), y[i]);
    lanes.stream_hash[i] = hash_combine(pixel_hash, half[i] & second);
    lanes.block[i] = half[i] >> second;
  }
  return lanes;
}

bool needs_time(uint32_t slot, int dimensions) {
  return slot == 0 && dimensions > camera_dim::kTime;
}

}  // namespace

void SobolSampler::fill_scattered(std::span<const SampleAddress> samples, uint32_t seed,
                                  uint32_t slot, int first_lane, SlotBlock& out,
                                  int dimensions) const {
  assert(first_lane >= 0 && size_t(first_lane) + samples.size() <= size_t(kSampleLanes));
  fill_scattered_pairs(samples, seed, slot, first_lane, out, dimensions);
  if (!needs_time(slot, dimensions)) return;
  fill_time(lanes_of(samples, seed, streams_), int(samples.size()),
            out.values[camera_dim::kTime] + first_lane);
}

void SobolSampler::fill_scattered_pairs(std::span<const SampleAddress> samples, uint32_t seed,
                                        uint32_t slot, int first_lane, SlotBlock& out,
                                        int dimensions) const {
  const uint32_t seed_hash = hash32(seed);
  // Many batches consist of whole blocks: the second half of a pixel's first 16 samples, and the
  // groups of eight that adaptive sampling adds. For these, the data that a block's samples share
  // is computed only once.
  const auto first_block = [&](const SampleAddress& a) {
    const uint32_t pixel_hash = hash_combine(hash_combine(seed_hash, a.x), a.y);
    return block_of(pixel_hash, a.sample / kBlockSize, streams_);
  };
  if (samples.size() == 2 * kBlockSize && is_whole_block(&samples[0]) &&
      is_whole_block(&samples[kBlockSize])) {
    const Block blocks[] = {first_block(samples[0]), first_block(samples[kBlockSize])};
    return fill_whole(blocks, slot, first_lane, out, dimensions);
  }
  if (samples.size() == kBlockSize && is_whole_block(&samples[0])) {
    const Block blocks[] = {first_block(samples[0])};
    return fill_whole(blocks, slot, first_lane, out, dimensions);
  }
  const ScatteredLanes lanes = lanes_of(samples, seed, streams_);
  const int pairs = dimensions <= 2 ? 1 : kSlotDimensions / 2;
  for (int p = 0; p < pairs; ++p) {
    alignas(64) float pair_x[kSampleLanes], pair_y[kSampleLanes];
    fill_scattered_pair(lanes, slot, p, pair_x, pair_y);
    std::copy_n(pair_x, samples.size(), out.values[2 * p] + first_lane);
    std::copy_n(pair_y, samples.size(), out.values[2 * p + 1] + first_lane);
  }
}

void SobolSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count,
                        SlotBlock& out, int dimensions) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  const uint32_t pixel_hash = hash_combine(hash_combine(hash32(pixel.seed), pixel.x), pixel.y);
  const auto block = [&](uint32_t half) { return block_of(pixel_hash, half, streams_); };
  // A pinhole camera uses only the pixel pair.
  if (dimensions <= 2) {
    fill_pairs<1>(block, slot, first_sample, count, out);
  } else {
    fill_pairs<kSlotDimensions / 2>(block, slot, first_sample, count, out);
  }
  if (!needs_time(slot, dimensions)) return;
  SampleAddress samples[kSampleLanes];
  for (int i = 0; i < count; ++i) samples[i] = {pixel.x, pixel.y, first_sample + uint32_t(i)};
  fill_time(lanes_of({samples, size_t(count)}, pixel.seed, streams_), count,
            out.values[camera_dim::kTime] + first_sample % kSampleLanes);
}

}  // namespace emberline
