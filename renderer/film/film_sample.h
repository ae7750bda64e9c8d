// All that a film is told of one sample.
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
  int half = 0;  // 0 or 1: the stream that the sample belongs to
  // Of the channels that want them; null or empty otherwise.
  const DenoiserFeatures* features = nullptr;
  const SampleShares* shares = nullptr;
  const CatcherSample* catcher = nullptr;
  const LightGroupValues* lights = nullptr;  // by light group
  const LightGroupValues* layers = nullptr;  // by light path, in the order of PathLayers
  int lane = 0;                              // of these two
  std::span<const uint32_t> ids = {};        // that Cryptomatte has of what was hit, one a kind
};

// False if the radiance, the first hit, the features or the catcher's values are NaN or infinite:
// the sample is then rejected in all channels.
bool is_finite(const FilmSample& sample);

}  // namespace emberline
