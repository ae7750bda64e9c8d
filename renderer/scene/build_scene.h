// SceneDescription -> Scene: builds what the frame uses and nothing else.
#pragma once

#include <memory>

#include "renderer/core/load_progress.h"
#include "renderer/description/scene_description.h"
#include "renderer/scene/scene.h"

namespace emberline {

struct SceneBuildOptions {
  bool show_backfaces = false;  // single-sided materials are seen from behind as well
  // False: a scene that lists its features and cannot be traced.
  bool bvh = true;
  // True: texture coordinates that no material reads are kept, for the integrator that shows them.
  bool unread_uv = false;
  // True: update_scene may be called. Vertex attributes that no material reads are kept, as are
  // the tables of an environment that is off, and the BVH's filter asks before it culls.
  bool editable = false;
};

// Takes the description over: its arrays become the scene's. Uses TBB. Throws InputError for a
// scene that cannot be placed in float's range, RenderError when memory runs out. The description
// goes through add_default_light first. Throws Cancelled if `progress` says so.
std::unique_ptr<Scene> build_scene(SceneDescription description, const SceneBuildOptions& options,
                                   LoadProgress& progress = LoadProgress::unwatched());

// Puts other materials, lights and another environment onto a scene, which then renders the same
// bits as one built from `description`; the BVH stays as it is. The description differs from the
// scene's in what SceneEdits change and in nothing else; its geometry is not looked at (an outline
// will do). `options` are those it was built with, editable. Nobody may use the scene meanwhile.
// Uses TBB. Throws InputError for a texture that cannot be, and has then changed nothing.
//
// What is made of the same parts as before is kept: emitters of materials that shine as before (the
// mean of an emissive texture over a triangle is what costs most), the light sampler where neither
// emitters nor lamps have changed, the tables of an environment that was turned, tinted or dimmed,
// the search for flush emitters where the same triangles emit.
void update_scene(Scene& scene, const SceneDescription& description,
                  const SceneBuildOptions& options);

}  // namespace emberline
