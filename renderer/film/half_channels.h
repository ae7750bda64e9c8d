// The channels of `--aov denoising`: means over each half of a pixel's samples.
//
// Of the first half half1.{R,G,B}, half1.albedo.{R,G,B}, half1.N.{X,Y,Z}, half1.nearness,
// half1.visibility (DenoiserFeatures says what they are), half1.samples, and
// half1.shared.K.{R,G,B,A}, what its samples count for the K-th of the 3 x 3 pixels around it and
// their weight (PixelFilter::shares); and so of the second. A finished frame has the sums of those
// (shared_samples.h). With light groups there are half1.light.NAME.{R,G,B}, too. Both halves
// weighted by their samples are the picture: of one that shows other means (FilmTile::show), both
// are moved by as much as that does.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer/core/picture_channel.h"

namespace emberline {

class FilmTile;

inline constexpr const char* kHalfNames[2] = {"half1", "half2"};

std::vector<PictureChannel> half_channels();
// Writes the values of pixel i, in their order.
void put_halves(const FilmTile& tile, size_t i, float* values);
// The same of the light groups of one half: three values each; returns the end.
float* put_half_lights(const FilmTile& tile, size_t i, int half, float* values);

}  // namespace emberline
