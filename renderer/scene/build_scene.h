// SceneDescription -> Scene: builds what the frame uses and nothing else.
#pragma once

#include <memory>
#include <optional>

#include "renderer/core/load_progress.h"
#include "renderer/description/scene_description.h"

namespace emberline {

enum class EmbreeIsa;  // renderer/scene/embree_isa.h
class Scene;

struct SceneBuildOptions {
  bool show_backfaces = false;  // single-sided materials are seen from behind as well
  // False: a scene that lists its features and cannot be traced.
  bool bvh = true;
  // True: texture coordinates that no material reads are kept, for the integrator that shows them.
  bool unread_uv = false;
  // True: update_scene may be called. Vertex attributes that no material reads are kept, as are
  // the tables of an environment that is off, and the BVH's filter asks before it culls.
  bool editable = false;
  // True, of an editable scene: repose_scene may be called. What no pose moves has a BVH of its
  // own, so that rays enter one instance more.
  bool posable = false;
  std::optional<EmbreeIsa> isa = {};  // of Embree's kernels; absent: the widest of the machine
};

// Takes the description over: its arrays become the scene's. Uses TBB. Throws InputError for a
// scene that cannot be placed in float's range, UsageError for kernels that this machine has not,
// RenderError when memory runs out. The description
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

// Puts the scene into another pose of its file: it then renders the same bits as one built from the
// whole of `posed`, where the meshes that the scene has (mesh_keys()) are held. Those and their
// BVHs are kept. What deforms is built anew, and what rests too where other instances come before
// it than did; so is the top level. Where nothing has moved at all it is an update_scene.
//
// False: this pose needs another internal space or other meshes than are held; it is to be built
// from a description that has them all. Nobody may use the scene meanwhile, and it may be another
// object afterwards. Throws what build_scene does. Where that or false is what comes, all is as it
// was.
bool repose_scene(std::unique_ptr<Scene>& scene, SceneDescription posed,
                  const SceneBuildOptions& options,
                  LoadProgress& progress = LoadProgress::unwatched());

}  // namespace emberline
