// Hierarchical sampling (Kajiya 1986, "The Rendering Equation", section "Hierarchical sampling"):
// sequential uniform samples of pixel, lens and time together, in five dimensions.
//
// A k-d tree halves the domain, dimension after dimension. Each new sample goes down it to the side
// that has fewer samples, by a coin where both have as many, and comes to lie in the empty half of
// the first cell that holds one sample. So any 2^m samples from the start have one in each of the
// 2^m cells of level m, and a prefix of any length is as even as it can be.
//
// Nothing of the tree is stored. At the root, samples alternate between the sides; so do those that
// reach any node: bit b of the sample's index is the side at depth b, but for a coin that belongs
// to the node, that is to the index's bits below b. A number whose bit b is flipped by a hash of
// the bits below is what owen_sobol::permute() computes: its result is the path, root first.
// The coin belongs to the node, not to the visit, so that sample k of [2^m, 2^(m+1)) comes to the
// cell of sample k - 2^m and halves it. This is what makes the leaves' volumes known:
// integration_weight() is Kajiya's hierarchical integration, the sum of each leaf's value times
// its volume, where after n = 2^m + j samples the first j cells of level m are halved.
//
// Pixel x, y, lens x, y and time are split in turn, so that 16 samples see the pixel in 2 x 2 cells
// only: the strength is what couples the five, the price is the plain edge.
//
// All other dimensions are those of `sobol`, so that a comparison of the two compares the tree.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"
#include "samplers/sobol_sampler.h"

namespace emberline {

class HierarchicalSampler final : public Sampler {
 public:
  // With two streams each has a tree of its own.
  explicit HierarchicalSampler(const SamplerSettings& settings)
      : streams_(settings.streams), rest_(settings) {}
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }
  // count times the volume of the sample's leaf: 1 for all if count (of each stream) is a power of
  // two. Unbiased for any count, since neither cells nor halves depend on values. Between powers of
  // two it pays where the last halving is of a dimension that matters; elsewhere leaves of unequal
  // weight cost variance, since coins that belong to nodes already spread the extra samples evenly
  // over the cells. At count = 2^m (1 + t) that is up to (1 + t)(1 - t/2) <= 9/8 times where a
  // halving brings nothing, and more where leaves not yet halved are the noisy ones.
  float integration_weight(uint32_t sample, uint32_t count) const override;

 private:
  StreamCount streams_;
  SobolSampler rest_;
};

}  // namespace emberline
