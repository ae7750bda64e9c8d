// Looks, with a few rays, from where a camera's paths go to the sky: whether little of the
// environment is seen there, and if so what of it from where.
//
// After the learning phase of Atanasov et al. 2018 (renderer/lights/environment_guide.h). A pure
// function of the scene and of the whole frame's view: the same for every driver, crop, part,
// sample count and seed, and so are the samples that it guides (law 1).
#pragma once

#include <memory>

namespace emberline {

class Camera;
class EnvironmentGuide;
class Scene;

// Null where the environment's samples find their way by themselves, or count for little beside
// those of lamps, or there is none: known after some ten thousand rays. Else it takes up to 13
// million more (1 in the rooms that were tried, which panes make dearer), fewer for frames of fewer
// than 16384 pixels, and up to 11 MB. Refers to the scene. Uses all threads.
std::shared_ptr<const EnvironmentGuide> find_environment_guide(const Scene& scene,
                                                               const Camera& camera, int width,
                                                               int height);

}  // namespace emberline
