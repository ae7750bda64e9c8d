// The channels of `--aov denoising`: means over each half of a pixel's samples.
//
// The channels of the first half are half1.{R,G,B}; half1.albedo.{R,G,B}, half1.N.{X,Y,Z},
// half1.nearness and half1.visibility (see DenoiserFeatures); half1.samples; and
// half1.shared.K.{R,G,B,A}. half1.shared.K.{R,G,B} is the light that these samples contribute to
// the K-th of the 3 x 3 pixels around this pixel, and half1.shared.K.A is the weight of this
// contribution (PixelFilter::shares). The second half has the same channels. In a finished frame
// the shared values are summed (shared_samples.h). With light groups there is also
// half1.light.NAME.{R,G,B}.
//
// The picture is the mean of both halves, each weighted by its sample count. If a pixel's value is
// overridden (FilmTile::set_override), both halves are shifted by the difference between the
// override and the mean of the samples.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer/core/picture_channel.h"

namespace emberline {

class FilmTile;

inline constexpr const char* kHalfNames[2] = {"half1", "half2"};

std::vector<PictureChannel> half_channels();
// Writes the values of pixel i in channel order.
void put_halves(const FilmTile& tile, size_t i, float* values);
// Writes three values for each light group of one half. Returns a pointer past the last value.
float* put_half_lights(const FilmTile& tile, size_t i, int half, float* values);

}  // namespace emberline
