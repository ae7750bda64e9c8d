// Ambient occlusion.
#pragma once

#include "integrators/surface_shading.h"

namespace emberline {

// How open the hemisphere above a point is, by one ray whose direction follows the cosine around
// the shading normal (S. Zhukov, A. Iones, G. Kronin, "An Ambient Light Illumination Model", EGWR
// 1998). Rays end after a fifth of the scene's radius, chosen by eye on interiors, which would be
// black with rays of any length. Takes the BSDF's numbers of the slot; `rays` counts, if it is
// there.
float openness(const Scene& scene, const ShadedPoint& point, float time, PixelSamples& samples,
               SampleRays* rays);

}  // namespace emberline
