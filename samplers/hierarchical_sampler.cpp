#include "samplers/hierarchical_sampler.h"

#include <bit>
#include <cassert>

#include "samplers/owen_sobol.h"
#include "samplers/sample_runs.h"

namespace emberline {
namespace {

constexpr uint32_t kHierarchicalSalt = 0x4a71ba86u;
constexpr int kTreeDimensions = camera_dim::kTime + 1;  // pixel, lens, time
constexpr int kTreeDepth = 32;
constexpr uint32_t kTreeSize = 1u << 31;  // samples; sample 2^31 starts another tree

// Values of dimension kDimension for samples with the given tree paths. The leading binary digits
// are the path's bits at depths kDimension, kDimension + 5, ...; a hash gives the rest.
template <int kDimension>
void fill_dimension(const uint32_t* path, const uint32_t* sample_hash, uint32_t key, int count,
                    float* values) {
  constexpr int kDigits = (kTreeDepth - kDimension + kTreeDimensions - 1) / kTreeDimensions;
  for (int i = 0; i < count; ++i) {
    uint32_t bits = hash32(sample_hash[i] ^ key) >> kDigits;
    for (int digit = 0; digit < kDigits; ++digit) {
      bits |= ((path[i] >> (kTreeDimensions * digit + kDimension)) & 1u) << (31 - digit);
    }
    values[i] = to_unit_float(bits);
  }
}

}  // namespace

void HierarchicalSampler::fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample,
                               int count, SlotBlock& out, int dimensions) const {
  assert(count >= 1 && first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
  if (slot != 0 || dimensions > kTreeDimensions) {
    fallback_.fill(pixel, slot, first_sample, count, out, dimensions);
  }
  if (slot != 0) return;
  for_each_run(streams_, {kTreeSize, kTreeSize}, first_sample, count, [&](const SampleRun& run) {
    const uint32_t tree = run_hash(pixel, run, kHierarchicalSalt);
    uint32_t path[kSampleLanes], sample_hash[kSampleLanes];
    for (int i = 0; i < run.count; ++i) {
      path[i] = owen_sobol::permute(run.index + uint32_t(i), tree);
      sample_hash[i] = hash32(run.index + uint32_t(i) + 0x9e3779b9u);
    }
    const auto fill_next = [&]<int kDimension>() {
      fill_dimension<kDimension>(path, sample_hash, hash_combine(tree, kDimension), run.count,
                                 out.values[kDimension] + run.lane);
    };
    fill_next.template operator()<0>();
    fill_next.template operator()<1>();
    if (dimensions <= 2) return;
    fill_next.template operator()<2>();
    fill_next.template operator()<3>();
    fill_next.template operator()<4>();
  });
}

float HierarchicalSampler::integration_weight(uint32_t sample, uint32_t count) const {
  assert(sample < count);
  const auto [stream, index] = stream_index(streams_, sample);
  const uint32_t length = stream_length(streams_, stream, count);
  const uint32_t cells = std::bit_floor(length);
  const bool halved = index % cells < length - cells;
  return float(length) / float(cells) * (halved ? 0.5f : 1.0f);
}

}  // namespace emberline
