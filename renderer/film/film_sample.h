// One sample, in the form in which it is added to a film.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/film/sample_shares.h"
#include "renderer/film/sample_value.h"

namespace emberline {

class LightGroupValues;

struct FilmSample {
  const SampleValue& value;
  float filter_weight = 1.0f;
  int half = 0;  // the sample's stream: 0 or 1
  // Inputs of optional channels; null or empty if not needed.
  const DenoiserFeatures* features = nullptr;
  const SampleShares* shares = nullptr;
  const CatcherSample* catcher = nullptr;
  const LightGroupValues* lights = nullptr;  // by light group
  const LightGroupValues* layers = nullptr;  // by light-path layer, in the order of PathLayers
  int lane = 0;                              // the sample's index in `lights` and `layers`
  std::span<const uint32_t> ids = {};        // Cryptomatte ids of the hit, one per kind
};

// Returns false if the radiance, first hit, features or catcher values are NaN or infinite. Such a
// sample counts as black in all channels.
bool is_finite(const FilmSample& sample);

}  // namespace emberline
