// Surveys the indirect light of a view, before the frame begins.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

namespace emberline {

class Camera;
class IndirectGuide;
struct LightGuide;
class MemoryBudget;
class Scene;

// The view and the paths to survey. `light_guide` is that of the frame; it may be null. `memory`
// may be null, too: no limit.
struct SurveyedView {
  const Scene& scene;
  const Camera& camera;
  int width, height;
  int max_depth;
  const LightGuide* light_guide;
  std::shared_ptr<MemoryBudget> memory;
};

struct IndirectSurvey {
  std::shared_ptr<const IndirectGuide> guide;  // null: paths are not guided
  // The fraction of the light at visible surfaces that other surfaces reflect, and the fraction of
  // the scattered rays that leave the scene; -1 if unknown.
  double indirect_fraction = -1, leaving_fraction = -1;

  std::string describe() const;  // for the report; empty if nothing is known
};

// Traces paths from the camera and builds a guide from them. There is no guide if too little of the
// light at visible surfaces is indirect or too many rays leave the scene (`always` skips these
// tests), if a guide could serve no surface, or after a stop request.
//
// The result is a pure function of the scene and the whole frame's view, independent of driver,
// crop, part, sample count and seed, so law 1 (renderer/README.md) also holds for guided paths. The
// survey traces 1.5 to 3 paths per pixel of a small frame, up to 10^5. It reserves up to 64 MiB
// while it runs, or throws LimitError; the guide has up to 2 MB. Uses all threads.
IndirectSurvey survey_indirect_light(const SurveyedView& view, bool always,
                                     const std::stop_token& stop);

}  // namespace emberline
