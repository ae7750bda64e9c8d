// Looks, with a few rays, from where a camera's paths go to the lights: which kind of them arrives
// there, whether little of the environment is seen, and if so what of it from where.
//
// The environment after the learning phase of Atanasov et al. 2018
// (renderer/lights/environment_guide.h). A pure function of the scene and of the whole frame's
// view: the same for every driver, crop, part, sample count and seed, and so are the samples that
// it guides (law 1).
#pragma once

#include <memory>
#include <stop_token>

namespace emberline {

class Camera;
class Scene;
struct LightGuide;

// Null where samples find the lights well enough by themselves, which is known after some ten
// thousand rays. Where the environment is to be looked for it takes up to 13 million more (1 in the
// rooms that were tried, which panes make dearer), fewer for frames of fewer than 16384 pixels, and
// up to 11 MB. Refers to the scene. Uses all threads. Null soon after a stop is requested, too.
std::shared_ptr<const LightGuide> find_light_guide(const Scene& scene, const Camera& camera,
                                                   int width, int height,
                                                   const std::stop_token& stop);

}  // namespace emberline
