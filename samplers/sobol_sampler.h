// Owen-scrambled Sobol' pairs in orders of their own, so that pairs are even together.
//
// Each pair of dimensions is one scrambled (0,2)-sequence. Pair 0 of slot 0, the pixel position,
// is taken in natural order: every prefix of 2^m samples is a (0,m,2)-net. So are those of the
// pairs that vary most together with it, in orders that were searched for this
// (owen_sobol::Order): the lens, light and BSDF samples of the first and of the second surface, the
// choices of lobe and light at the first; time likewise. A pixel's picture depends on where in the
// pixel and in which direction together: where both are stratified as one its variance is .8 to 1
// times as large at 64 samples (tests/bench/results/samplers.md).
//
// Every other pair visits its sequence in an order drawn for it, else pairs would be copies of each
// other: the order of blocks of 8 is an Owen shuffle, the order within a block a random
// permutation. At multiples of 16 samples each is again stratified as well as ever. Either half
// alone is a trap. With the Owen shuffle only, low index bits stay matched, and strata
// of two pairs meet in whole pairs: exp(-4 |a - b|^2) comes out at 1.4 times, and sign x sign at 2
// times the variance of random numbers. With the permutation only, structure finer than a block
// stays matched: 1 + N/64 times. With both: 0.93 to 0.98, 8/7 and 9/8, the last two exactly as
// theory has it for blocks of 8. In searched orders the first two have .27 times and none at 64
// samples; the last, one fine frequency of the many, 2.
//
// With two streams, sample k belongs to stream (k >> 3) & 1, as its index ((k >> 4) << 3) | (k &
// 7); the streams are independent randomisations, so (A - B)^2 / 4 is an honest estimate of the
// variance of the pixel's mean (A + B) / 2. Counts are then best multiples of 16.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"

namespace emberline {

class SobolSampler final : public Sampler {
 public:
  explicit SobolSampler(const SamplerSettings& settings) : streams_(settings.streams) {}
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }
  void fill_scattered(std::span<const SampleAddress> samples, uint32_t seed, uint32_t slot,
                      int first_lane, SlotBlock& out, int dimensions) const override;

 private:
  void fill_scattered_pairs(std::span<const SampleAddress> samples, uint32_t seed, uint32_t slot,
                            int first_lane, SlotBlock& out, int dimensions) const;

  StreamCount streams_;
};

}  // namespace emberline
