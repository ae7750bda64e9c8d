// Replaces texel values that the renderer cannot use, and counts them.
#pragma once

#include "renderer/core/colour_matrix.h"
#include "renderer/description/scene_description.h"

namespace emberline {

enum class TexelRange {
  kFinite,    // NaN and infinite texels become 0
  kRadiance,  // NaN, infinite and negative texels become 0
};

// Repairs a half or float image in place, in parallel. Does nothing to integer images. Returns the
// number of changed components.
uint64_t repair_texels(Image& image, TexelRange range);

// Divides colour by alpha (the last of 2 or 4 channels) where alpha is not 0. Integers are rounded.
void unpremultiply(Image& image);

// Converts three channels of finite half or float texels to other primaries. Values that become
// negative stay negative, except for rounding errors, which become 0. The result is finite.
void convert_primaries(Image& image, const ColourMatrix& matrix);

// Turns a one-channel image into one with three identical channels.
void expand_grey(Image& image);

// Inverts the sRGB curve, IEC 61966-2-1.
float srgb_to_linear(float encoded);

}  // namespace emberline
