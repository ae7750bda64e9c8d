// Texel values that no renderer can use, made usable and counted.
#pragma once

#include "renderer/core/colour_matrix.h"
#include "renderer/description/scene_description.h"

namespace emberline {

enum class TexelRange {
  kFinite,    // NaN and infinite texels become 0
  kRadiance,  // NaN, infinite and negative ones become 0
};

// Repairs a half or float image in place, in parallel; integer images have nothing to repair.
// Returns how many texel components were changed.
uint64_t repair_texels(Image& image, TexelRange range);

// Colour divided by alpha (the last of 2 or 4 channels), rounded for integers. Where alpha is 0 the
// colour stays.
void unpremultiply(Image& image);

// Three channels of finite half or float texels as colours of other primaries. What is negative
// then by more than rounding stays so; a half stays finite.
void convert_primaries(Image& image, const ColourMatrix& matrix);

// One channel to three equal ones.
void expand_grey(Image& image);

// IEC 61966-2-1.
float srgb_to_linear(float encoded);

}  // namespace emberline
