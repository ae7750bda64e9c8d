#include "samplers/sampler.h"

#include <vector>

#include "renderer/core/errors.h"
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
  std::vector<std::string_view> names;
  for (const SamplerEntry& entry : kSamplers) {
    if (entry.name == name) return entry.create(settings);
    names.push_back(entry.name);
  }
  throw UsageError(unknown_name_message("sampler", name, names));
}

}  // namespace emberline
