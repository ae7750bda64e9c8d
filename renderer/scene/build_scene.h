// SceneDescription -> Scene: builds what the frame uses and nothing else.
#pragma once

#include <memory>

#include "renderer/scene/scene.h"
#include "renderer/scene/scene_description.h"

namespace emberline {

struct SceneBuildOptions {
  bool show_backfaces = false;  // single-sided materials are seen from behind as well
  // False: a scene that lists its features and cannot be traced.
  bool bvh = true;
  // True: texture coordinates that no material reads are kept, for the integrator that shows them.
  bool unread_uv = false;
  LightSamplerSettings lights;
};

// Takes the description over: its arrays become the scene's. Uses TBB. Throws InputError for a
// scene that cannot be placed in float's range, RenderError when memory runs out. A description
// without any light gets a white environment, and a warning.
std::unique_ptr<Scene> build_scene(SceneDescription description, const SceneBuildOptions& options);

// Bounds of all placed geometry, world space; empty (min > max) without geometry.
struct WorldBounds {
  Vec3d min = Vec3d(1e300), max = Vec3d(-1e300);
  bool empty() const { return !(min.x <= max.x); }
  Vec3d center() const { return (min + max) * 0.5; }
  double radius() const { return empty() ? 0.0 : (max - min).length() * 0.5; }
};
WorldBounds world_bounds(const SceneDescription& description);

// A camera that frames everything, for files that have none: from the front, a little from the
// right and above, 40 degrees high.
CameraDescription framing_camera(const WorldBounds& bounds, double aspect);

}  // namespace emberline
