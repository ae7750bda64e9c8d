#include "samplers/sampler.h"

#include "renderer/core/names.h"
#include "samplers/independent_sampler.h"
#include "samplers/sobol_sampler.h"

namespace emberline {
namespace {

template <typename T>
std::unique_ptr<Sampler> make(const SamplerSettings& settings) {
  return std::make_unique<T>(settings);
}

// The first row is the default.
constexpr SamplerEntry kSamplers[] = {
    {"sobol", "Owen-scrambled Sobol' pairs: the least noise for the same samples",
     make<SobolSampler>},
    {"independent", "plain random numbers: no stratification, the yardstick",
     make<IndependentSampler>},
};

}  // namespace

void Sampler::fill_scattered(std::span<const SampleAddress> samples, uint32_t seed, uint32_t slot,
                             int first_lane, SlotBlock& out, int dimensions) const {
  SlotBlock block;
  for (size_t i = 0; i < samples.size(); ++i) {
    const SampleAddress& address = samples[i];
    fill({address.x, address.y, seed}, slot, address.sample, 1, block, dimensions);
    for (int d = 0; d < dimensions; ++d) {
      out.values[d][size_t(first_lane) + i] = block.values[d][address.sample % kSampleLanes];
    }
  }
}

std::span<const SamplerEntry> sampler_table() { return kSamplers; }

std::unique_ptr<Sampler> create_sampler(std::string_view name, const SamplerSettings& settings) {
  return find_named(kSamplers, "--sampler", "sampler", name).create(settings);
}

}  // namespace emberline
