// Distributes error over the frame as blue noise (Ahmed & Wonka 2020, "Screen-space blue-noise
// diffusion of Monte Carlo sampling error via hierarchical ordering of pixels", ACM TOG 39(6)).
//
// One Owen-scrambled Sobol' sequence serves all pixels (of a tile, if the frame is very large).
// Each pixel takes an aligned range of samples_per_pixel points. The ranges follow a Z-curve
// through the frame. Each base-4 digit of the curve's index is permuted at random, by a hash of the
// higher digits. So the points of any aligned square of 2 x 2, 4 x 4, ... pixels together form an
// evenly spread set (a net): where one pixel's estimate is too bright, its neighbours' are too
// dark. The error lies in high frequencies, which the eye and a denoiser average away.
//
// Each pair of dimensions has its own permutations and scrambles. Within a pair, each pixel
// shuffles the points of its range. The pair of the pixel position uses an Owen shuffle, so that
// each prefix of 2^m samples is a (0,m,2)-net. The other pairs use a random shuffle: with an Owen
// shuffle, the strata of two pairs would stay matched (sobol_sampler.h).
//
// The sequence covers a square that holds the whole frame and whose side in pixels is a power of
// two. So a pixel has the same numbers in a crop as in the whole frame.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"

namespace emberline {

class BlueNoiseSampler final : public Sampler {
 public:
  // samples_per_pixel must be a power of two. The frame is cut into square tiles, each small enough
  // for one sequence of 2^32 points. The tiles are randomised independently. One tile is enough for
  // frames up to 8192 x 8192 at 64 samples per pixel, or up to 1024 x 1024 at 4096. With two
  // streams, each is a separate sequence with half the samples.
  explicit BlueNoiseSampler(const SamplerSettings& settings);
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }

 private:
  StreamCount streams_;
  uint32_t samples_;      // per pixel and stream
  uint32_t tile_digits_;  // tiles are 2^tile_digits_ pixels wide and high
};

}  // namespace emberline
