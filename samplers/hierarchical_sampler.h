// Hierarchical sampling (Kajiya 1986, "The Rendering Equation", section "Hierarchical sampling"):
// sequential uniform samples of pixel, lens and time together, in five dimensions.
//
// A k-d tree halves the domain, one dimension after another. Each new sample descends to the side
// that has fewer samples, or to a random side if both have equally many. It lands in the empty half
// of the first cell that holds one sample. So each of the 2^m cells of level m contains one of the
// first 2^m samples, and a prefix of any length is as even as possible.
//
// The tree is not stored. Samples that reach a node alternate between its sides: bit b of the
// sample's index gives the side at depth b, flipped by a random coin. The coin belongs to the node,
// that is, it depends on the index's bits below b. owen_sobol::permute() does exactly this: it
// flips each bit by a hash of the lower bits. Its result is the path through the tree, with the
// side at the root in bit 0.
//
// Because the coin belongs to the node and not to the visit, a sample k in [2^m, 2^(m+1)) falls
// into the cell of sample k - 2^m and halves it. Therefore the leaves' volumes are known: after
// n = 2^m + j samples, the cells of the first j samples are halved. integration_weight() uses these
// volumes for Kajiya's hierarchical integration, which sums each leaf's value times its volume.
//
// Pixel x, pixel y, lens x, lens y and time are split in turn, so 16 samples stratify the pixel in
// only 2 x 2 cells. Effects that couple the five dimensions become less noisy, but plain edges
// become noisier.
//
// All other dimensions come from `sobol`, so a comparison of the two samplers shows the effect of
// the tree alone.
#pragma once

#include "samplers/sample_runs.h"
#include "samplers/sampler.h"
#include "samplers/sobol_sampler.h"

namespace emberline {

class HierarchicalSampler final : public Sampler {
 public:
  // With two streams, each has a separate tree.
  explicit HierarchicalSampler(const SamplerSettings& settings)
      : streams_(settings.streams), fallback_(settings) {}
  void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count, SlotBlock& out,
            int dimensions) const override;
  StreamIndex stream_of(uint32_t sample) const override { return stream_index(streams_, sample); }
  // Returns the volume of the sample's leaf times n, the number of samples in the sample's stream.
  // All weights are 1 if n is a power of two. The estimate is unbiased for any n, since neither the
  // cells nor the coins depend on the integrand. Between powers of two, the weights help if the
  // last halving is along a dimension that matters. Otherwise unequal weights add variance, because
  // the coins already spread the extra samples evenly over the cells. With n = 2^m (1 + t), the
  // weights multiply the variance by up to (1 + t)(1 - t/2) <= 9/8 where a halving gains nothing.
  // The factor is larger where the leaves that are not yet halved are the noisy ones.
  float integration_weight(uint32_t sample, uint32_t count) const override;

 private:
  StreamCount streams_;
  SobolSampler fallback_;
};

}  // namespace emberline
