// Where an emitter is, which way it shines and how strongly, for as long as the shutter is open.
#pragma once

#include "renderer/lights/light_bvh.h"
#include "renderer/lights/light_sampler.h"

namespace emberline {

// An intensity of 0: it gives no light, or has no area that floats can tell. `motion` is looked at
// for a triangle that moves.
EmitterBounds bounds_of(const EmissiveTriangle& triangle, const EmitterMotion* motion);
EmitterBounds bounds_of(const PointLight& light);

}  // namespace emberline
