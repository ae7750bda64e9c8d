#include "samplers/blue_noise_sampler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "samplers/owen_sobol.h"
#include "samplers/random_permutation.h"
#include "samplers/sample_runs.h"

namespace emberline {
namespace {

constexpr uint32_t kBlueNoiseSalt = 0xb1e0015eu;

// The 24 permutations of four digits; permutation p maps digit d to (p >> 2d) & 3.
constexpr std::array<uint32_t, 24> orders_of_4() {
  std::array<uint32_t, 24> orders{};
  size_t count = 0;
  for (uint32_t a = 0; a < 4; ++a) {
    for (uint32_t b = 0; b < 4; ++b) {
      for (uint32_t c = 0; c < 4; ++c) {
        const uint32_t d = 6 - a - b - c;
        if (a == b || a == c || b == c) continue;
        orders[count++] = a | b << 2 | c << 4 | d << 6;
      }
    }
  }
  return orders;
}
constexpr std::array<uint32_t, 24> kOrders = orders_of_4();

// Moves bit i of a 16-bit number to bit 2i.
constexpr uint32_t spread_bits(uint32_t x) {
  x = (x | x << 8) & 0x00ff00ffu;
  x = (x | x << 4) & 0x0f0f0f0fu;
  x = (x | x << 2) & 0x33333333u;
  return (x | x << 1) & 0x55555555u;
}

// Permutes each base-4 digit of a pixel's Z-curve position by a hash of the digits above it.
uint32_t shuffle_morton_digits(uint32_t morton_index, uint32_t digits, uint32_t key) {
  uint32_t shuffled = 0;
  for (uint32_t i = 0; i < digits; ++i) {
    // The digits above this one, with a marker bit for the level, identify the square whose four
    // quadrants are permuted.
    const uint32_t square = uint32_t(uint64_t(morton_index) >> (2 * i + 2)) | 1u << (2 * (15 - i));
    const uint32_t pick = (hash32(key ^ hash32(square)) >> 16) * 24 >> 16;
    const uint32_t digit = (morton_index >> (2 * i)) & 3u;
    shuffled |= ((kOrders[pick] >> (2 * digit)) & 3u) << (2 * i);
  }
  return shuffled;
}

}  // namespace

BlueNoiseSampler::BlueNoiseSampler(const SamplerSettings& settings)
    : streams_(settings.streams), samples_(stream_length(streams_, 0, settings.samples_per_pixel)) {
  assert(std::has_single_bit(settings.samples_per_pixel));
  const auto side = uint32_t(std::max(settings.width, settings.height));
  const auto places = uint32_t(32 - std::countr_zero(samples_)) / 2;
  tile_digits_ = std::min(uint32_t(std::bit_width(side - 1)), places);
}

void BlueNoiseSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count,
                            SlotBlock& out, int dimensions) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  const PixelKey tile{pixel.x >> tile_digits_, pixel.y >> tile_digits_, pixel.seed};
  const uint32_t in_tile = (1u << tile_digits_) - 1;
  const uint32_t morton_index = spread_bits(pixel.x & in_tile) | spread_bits(pixel.y & in_tile)
                                                                     << 1;
  for_each_run(streams_, {samples_, samples_}, first_sample, count, [&](const SampleRun& run) {
    const uint32_t slot_hash = hash_combine(run_hash(tile, run, kBlueNoiseSalt), slot);
    for (int d = 0; d < dimensions; d += 2) {
      const uint32_t key = hash_combine(slot_hash, uint32_t(d));
      const uint32_t first_index =
          shuffle_morton_digits(morton_index, tile_digits_, key) * samples_;
      uint32_t within[kSampleLanes];
      const uint32_t order_key = hash_combine(key, morton_index);
      if (slot == 0 && d == camera_dim::kPixelX) {
        for (int i = 0; i < run.count; ++i) {
          within[i] =
              owen_sobol::shuffle_index(run.index + uint32_t(i), order_key) & (samples_ - 1);
        }
      } else {
        RandomPermutation(samples_, order_key).places(run.index, run.count, within);
      }
      const uint32_t seed_x = hash_combine(key, 0xffffffffu), seed_y = hash32(seed_x);
      float* x = out.values[d] + run.lane;
      float* y = out.values[d + 1] + run.lane;
      for (int i = 0; i < run.count; ++i) {
        const uint32_t index = first_index + within[i];
        x[i] = owen_sobol::reversed_to_unit_float(owen_sobol::permute(index, seed_x));
        y[i] = owen_sobol::reversed_to_unit_float(
            owen_sobol::permute(owen_sobol::pascal(index), seed_y));
      }
    }
  });
}

}  // namespace emberline
