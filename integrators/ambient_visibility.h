// Ambient occlusion.
#pragma once

#include "integrators/surface_shading.h"

namespace emberline {

// Estimates the openness of the hemisphere above a point from one ray with a cosine-weighted
// direction around the shading normal (S. Zhukov, A. Iones, G. Kronin, "An Ambient Light
// Illumination Model", EGWR 1998). Rays end after a fifth of the scene's radius, a limit that we
// chose by eye; without one, interiors would be black. Uses the slot's BSDF random numbers. `rays`
// may be null.
float ambient_visibility(const Scene& scene, const ShadedPoint& point, float time,
                         PixelSamples& samples, SampleRays* rays);

}  // namespace emberline
