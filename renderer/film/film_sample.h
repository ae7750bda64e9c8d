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

// Radiance and alpha of every channel at once: a sample with a value that is NaN or infinite is
// none.
bool is_finite(const FilmSample& sample);

}  // namespace emberline
