// A frame's two halves prepared for filtering: finite, padded, and with their own noise.
#pragma once

#include <array>
#include <vector>

#include "renderer/reconstruction/bordered_plane.h"
#include "renderer/reconstruction/denoise.h"

namespace emberline {

using ColourPlanes = std::array<BorderedPlane, 3>;

struct Half {
  BorderedPlane count;
  BorderedPlane known;            // 1 with samples, 0 without and outside the image
  BorderedPlane inlier_fraction;  // fraction of the pixel's colour without the excess
  ColourPlanes colour;
  BorderedPlane noise;  // variance of `colour`, channels summed, pooled over neighbours
};

struct Feature {
  BorderedPlane value;
  BorderedPlane noise;  // variance of `value`
};

struct Halves {
  int width = 0, height = 0;
  std::array<Half, 2> half;
  ColourPlanes raw;                    // mean of all samples
  ColourPlanes excess;                 // of outliers; in neither `raw` nor the halves' colours
  std::array<BorderedPlane, 2> share;  // of a half in a pixel's mean; 1/2 without samples
  BorderedPlane both_known;            // 1 where both halves are known
  // The pixel's variance estimated from its two halves only, channels summed: one degree of
  // freedom. 0 if a half is unknown.
  BorderedPlane own_noise;
  // This variance per channel for the input, before samples are shared and outliers limited.
  ColourPlanes raw_noise;
  std::vector<Feature> features;
};

// Radius over which a pixel's noise is pooled: a single difference gives less than a tenth of the
// true value in every fourth pixel.
inline constexpr int kNoiseRadius = 2;

// Radius of the comparison for outliers.
inline constexpr int kOutlierRadius = 2;

// Reads `input` except for its parts.
Halves prepare_halves(const DenoiseInput& input);

// One channel of an image in the form of the halves: finite, padded, without its outliers' excess.
struct Channel {
  std::array<BorderedPlane, 2> half;
  BorderedPlane raw, excess;
};
Channel read_channel(const Halves& halves, const HalfPlanes& planes);

}  // namespace emberline
