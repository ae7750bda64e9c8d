// Measures which lights reach a view. A few paths from the camera find surfaces, and rays from
// these surfaces to the lights find out which kinds of light arrive there. If little of the
// environment is visible, the survey also measures which part of it is visible from where.
//
// The environment guide follows the learning phase of Atanasov et al. 2018
// (renderer/lights/environment_guide.h). The guide is a pure function of the scene and the whole
// frame's view, independent of driver, crop, part, sample count and seed. So law 1
// (renderer/README.md) also holds for the samples that it guides.
#pragma once

#include <memory>
#include <stop_token>

namespace emberline {

class Camera;
class Scene;
struct LightGuide;

// Returns null if light samples are good enough without a guide; finding that out takes about ten
// thousand rays. An environment guide takes up to 11 MB of memory and up to 13 million more rays.
// In the rooms that we tried, it took 1 million rays; rays through panes cost more. Frames with
// fewer than 16384 pixels need fewer rays. Also returns null soon after a stop request. The result
// refers to the scene. Uses all threads.
std::shared_ptr<const LightGuide> find_light_guide(const Scene& scene, const Camera& camera,
                                                   int width, int height,
                                                   const std::stop_token& stop);

}  // namespace emberline
