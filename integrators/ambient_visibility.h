// Ambient occlusion.
#pragma once

#include "integrators/surface_shading.h"

namespace emberline {

// Estimates the openness of the hemisphere above a point from one ray with a cosine-weighted
// direction around the shading normal (S. Zhukov, A. Iones, G. Kronin, "An Ambient Light
// Illumination Model", EGWR 1998). The ray ends after a fifth of the scene's radius; without a
// limit, interiors would be black. We chose this one by eye. Uses the slot's BSDF random numbers.
// `rays` may be null.
float ambient_visibility(const Scene& scene, const ShadedPoint& point, float time,
                         PixelSamples& samples, SampleRays* rays);

}  // namespace emberline
