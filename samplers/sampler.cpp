#include "samplers/sampler.h"

#include <bit>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "samplers/blue_noise_sampler.h"
#include "samplers/hierarchical_sampler.h"
#include "samplers/independent_sampler.h"
#include "samplers/poisson_disk_sampler.h"
#include "samplers/sobol_sampler.h"
#include "samplers/stratified_sampler.h"

namespace emberline {
namespace {

template <typename T>
std::unique_ptr<Sampler> make(const SamplerSettings& settings) {
  return std::make_unique<T>(settings);
}

// The first row is the default.
constexpr SamplerEntry kSamplers[] = {
    {"sobol", "Owen-scrambled Sobol' points: least noise for a given number of samples",
     SampleCounts::kAny, ConvergenceRate::kSobol, make<SobolSampler>},
    {"blue_noise", "one Sobol' sequence along the pixels' Z-order: less visible noise",
     SampleCounts::kPowerOfTwo, ConvergenceRate::kUnknown, make<BlueNoiseSampler>},
    {"stratified", "jittered: one random point in each of `spp` equal cells", SampleCounts::kFixed,
     ConvergenceRate::kJittered, make<StratifiedSampler>},
    {"poisson_disk", "points that keep their distance: aliasing becomes high-frequency noise",
     SampleCounts::kAny, ConvergenceRate::kUnknown, make<PoissonDiskSampler>},
    {"hierarchical", "Kajiya's sequential uniform sampling over pixel, lens and time together",
     SampleCounts::kAny, ConvergenceRate::kUnknown, make<HierarchicalSampler>, true},
    {"independent", "plain random numbers without stratification, as a baseline",
     SampleCounts::kAny, ConvergenceRate::kIndependent, make<IndependentSampler>},
};

void check_count(const SamplerEntry& entry, uint32_t samples) {
  if (entry.counts != SampleCounts::kPowerOfTwo || std::has_single_bit(samples)) return;
  const uint32_t below = std::bit_floor(samples);
  throw UsageError(
      "`spp`: " + std::to_string(samples) + " is not a power of two. `sampler` " +
      std::string(entry.name) +
      " requires one, because its pixels share one sequence; the nearest valid values are " +
      std::to_string(below) + " and " + std::to_string(uint64_t(below) * 2));
}

}  // namespace

std::vector<std::string_view> extensible_samplers() {
  std::vector<std::string_view> names;
  for (const SamplerEntry& entry : kSamplers) {
    if (entry.counts == SampleCounts::kAny && !entry.weighted) names.push_back(entry.name);
  }
  return names;
}

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
  const SamplerEntry& entry = find_named(kSamplers, "`sampler`", "sampler", name);
  check_count(entry, settings.samples_per_pixel);
  return entry.create(settings);
}

}  // namespace emberline
