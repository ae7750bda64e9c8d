// What a surface that catches shadows receives of a light, with the scene's other objects and
// without.
#pragma once

#include "integrators/integrator.h"
#include "renderer/scene/scene.h"

namespace emberline {

// A camera ray has met a catcher; `weight` is what panes on its way let through. The numbers are
// those of the surface's own light sample, and `guide` is SampleBatch::catcher_guide.
void catch_light(const Scene& scene, const SurfaceRoles& roles, const Ray& ray,
                 const SurfaceHit& hit, float weight, const LightGuide* guide,
                 PixelSamples& samples, SampleRays* rays, CatcherSample* sample);

}  // namespace emberline
