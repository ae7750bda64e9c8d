// A frame's two halves made ready to be filtered: finite, padded, and with their own noise.
#pragma once

#include <array>
#include <vector>

#include "renderer/reconstruction/bordered_plane.h"
#include "renderer/reconstruction/denoise.h"

namespace emberline {

using ColourPlanes = std::array<BorderedPlane, 3>;

struct Half {
  BorderedPlane count;
  BorderedPlane known;  // 1 where there are samples, 0 where there are none and outside the picture
  BorderedPlane within;  // what share of the pixel's colour is no excess
  ColourPlanes colour;
  BorderedPlane
      noise;  // variance of `colour`, its channels summed, from this pixel and its neighbours
};

struct Feature {
  BorderedPlane value;
  BorderedPlane noise;  // variance of that value
};

struct Halves {
  int width = 0, height = 0;
  std::array<Half, 2> half;
  ColourPlanes raw;     // the mean of all samples
  ColourPlanes excess;  // of outliers, which is in neither `raw` nor the halves' colours
  std::array<BorderedPlane, 2>
      share;           // of either half in a pixel's mean; 1/2 where there is no sample
  BorderedPlane told;  // 1 where both halves are known
  // The pixel's variance as its two halves alone tell it, channels summed: one degree of
  // freedom. 0 where a half is unknown.
  BorderedPlane own_noise;
  // The same of each channel of the picture as it came, before samples are shared and outliers
  // limited.
  ColourPlanes raw_noise;
  std::vector<Feature> features;
};

// How far around the noise of a pixel is pooled: one difference alone says less than a tenth of the
// truth in every fourth pixel.
inline constexpr int kNoiseRadius = 2;

// The reach of what an outlier is measured by.
inline constexpr int kOutlierRadius = 2;

// Reads `input` but for its parts.
Halves prepare_halves(const DenoiseInput& input);

// One channel of a picture as the halves have it: finite, padded, without its outliers' excess.
struct Channel {
  std::array<BorderedPlane, 2> half;
  BorderedPlane raw, excess;
};
Channel read_channel(const Halves& halves, const HalfPlanes& planes);

}  // namespace emberline
