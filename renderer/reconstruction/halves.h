// The two halves of a frame's samples, prepared for filtering: finite, padded, and with their
// noise.
#pragma once

#include <array>
#include <vector>

#include "renderer/reconstruction/bordered_plane.h"
#include "renderer/reconstruction/denoise.h"

namespace emberline {

using ColourPlanes = std::array<BorderedPlane, 3>;

struct Half {
  BorderedPlane count;
  BorderedPlane known;            // 1 where there are samples, 0 elsewhere and outside the image
  BorderedPlane inlier_fraction;  // fraction of the pixel's colour that is not outlier excess
  ColourPlanes colour;
  BorderedPlane noise;  // variance of `colour`, summed over channels, pooled over neighbours
};

struct Feature {
  BorderedPlane value;
  BorderedPlane noise;  // variance of `value`
};

struct Halves {
  int width = 0, height = 0;
  std::array<Half, 2> half;
  ColourPlanes raw;     // mean of all samples
  ColourPlanes excess;  // excess light of outliers; in neither `raw` nor the halves' colours
  std::array<BorderedPlane, 2> share;  // a half's weight in a pixel's mean; 1/2 without samples
  BorderedPlane both_known;            // 1 where both halves are known
  // The pixel's variance estimated only from the difference of its own two halves (one degree of
  // freedom), summed over channels. 0 if a half is unknown.
  BorderedPlane own_noise;
  // Like own_noise, but for each channel, and measured without DenoiseInput::shared and before
  // outliers are limited.
  ColourPlanes raw_noise;
  std::vector<Feature> features;
};

// Radius over which a pixel's noise is pooled. Without pooling, a single difference would
// underestimate the noise by more than a factor of ten in every fourth pixel.
inline constexpr int kNoiseRadius = 2;

// Radius within which a pixel is compared to its neighbours to find outliers.
inline constexpr int kOutlierRadius = 2;

// Reads everything in `input` except its parts.
Halves prepare_halves(const DenoiseInput& input);
// Like prepare_halves(), but ignores the features.
Halves prepare_colour(const DenoiseInput& input);

// Returns the values, made finite and padded.
BorderedPlane padded_plane(std::span<const float> values, int width, int height);

// One channel of an image, prepared like the halves: finite, padded, without the excess of
// outliers.
struct Channel {
  std::array<BorderedPlane, 2> half;
  BorderedPlane raw, excess;
};
Channel read_channel(const Halves& halves, const HalfPlanes& planes);

}  // namespace emberline
