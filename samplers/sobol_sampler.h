// Owen-scrambled Sobol' pairs, visited in index orders that stratify some pairs jointly.
//
// Each pair of dimensions is one scrambled (0,2)-sequence. Pair 0 of slot 0, the pixel position,
// takes the points in natural order, so every prefix of 2^m samples is a (0,m,2)-net. The same
// holds for the pairs whose effects depend most on the pixel position: the lens, light and BSDF
// samples of the first and second surface, the choices of lobe and light at the first surface, and
// the time. These pairs use index orders found by a search (owen_sobol::Order). At 64 samples,
// stratifying position and direction jointly multiplies a pixel's variance by .8 to 1
// (tests/bench/results, "Noise and sparkle").
//
// Every other pair visits its sequence in a random order, since pairs would otherwise be copies of
// each other. The order is an Owen shuffle of blocks of 8, with a random permutation within each
// block. At multiples of 16 samples, each pair is still fully stratified. Both steps are needed.
// The following factors are variances divided by the variance of random numbers:
// - Only the Owen shuffle: low index bits stay matched between pairs. The factor is 1.4 for the
//   integrand exp(-4|a-b|^2), and 2 for a product of two signs.
// - Only the permutation: structure finer than a block stays matched. This third factor is 1 + N/64
//   for N samples.
// - Both steps: the three factors are 0.93 to 0.98, 8/7 and 9/8. Theory predicts exactly the last
//   two for blocks of 8.
// - The searched orders at 64 samples: the first two factors are .27 and 0. The third is 2 for one
//   fine frequency among many.
//
// With two streams, sample k belongs to stream (k >> 3) & 1, at index ((k >> 4) << 3) | (k & 7).
// The streams are independent randomisations. With A and B as the means of the two streams,
// (A - B)^2 / 4 is an unbiased estimate of the variance of the pixel's mean (A + B) / 2. The best
// sample counts for two streams are multiples of 16.
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
