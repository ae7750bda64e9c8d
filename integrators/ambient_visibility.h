// Estimates ambient occlusion.
#pragma once

#include "integrators/surface_shading.h"

namespace emberline {

// Estimates from one ray how open the hemisphere above a point is, from 0 to 1. The ray's direction
// is cosine-weighted around the shading normal (S. Zhukov, A. Iones, G. Kronin, "An Ambient Light
// Illumination Model", EGWR 1998). The ray ends after a fifth of the scene's radius, a limit that
// we chose by eye. Without a limit, interiors would be black. Uses the slot's BSDF random numbers.
// `rays` may be null.
float ambient_visibility(const Scene& scene, const ShadedPoint& point, float time,
                         PixelSamples& samples, SampleRays* rays);

}  // namespace emberline
