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

std::span<const SamplerEntry> sampler_table() { return kSamplers; }

std::unique_ptr<Sampler> create_sampler(std::string_view name, const SamplerSettings& settings) {
  return find_named(kSamplers, "--sampler", "sampler", name).create(settings);
}

}  // namespace emberline
