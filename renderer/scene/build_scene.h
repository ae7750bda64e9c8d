// Builds a Scene from a SceneDescription. The Scene contains only what the frame uses.
#pragma once

#include <memory>
#include <optional>

#include "renderer/core/load_progress.h"
#include "renderer/description/scene_description.h"

namespace emberline {

enum class EmbreeIsa;  // renderer/scene/embree_isa.h
class Scene;

struct SceneBuildOptions {
  bool show_backfaces = false;  // single-sided materials are also visible from behind
  // If false, the scene has no BVH. It lists its features but cannot be traced.
  bool bvh = true;
  // If true, keeps texture coordinates that no material reads, for the integrator that shows them.
  bool unread_uv = false;
  // If true, update_scene() may be called. The scene then keeps data that edits may need: vertex
  // attributes that no material reads, and the tables of an environment that is switched off. The
  // BVH's filter then decides about culling at each hit.
  bool editable = false;
  // If true (for editable scenes only), repose_scene() may be called. Geometry that no pose moves
  // then gets a separate BVH, in one more Embree instance that rays have to enter.
  bool posable = false;
  std::optional<EmbreeIsa> isa = {};  // Embree's kernels; by default the widest available
};

// Takes over the description's arrays and calls add_default_light() first. Uses TBB. Throws
// InputError for a scene that exceeds float's range, UsageError for kernels that this machine
// lacks, RenderError if memory runs out, Cancelled if `progress` is cancelled.
std::unique_ptr<Scene> build_scene(SceneDescription description, const SceneBuildOptions& options,
                                   LoadProgress& progress = LoadProgress::none());

// Replaces a scene's materials, lights and environment. The scene then renders bit-identically to
// one built from `description`, but keeps its BVH. `description` may differ from the description of
// the scene only by SceneEdits. Its geometry is not read, so the result of copy_without_geometry()
// is enough. `options` must be those passed to build_scene(), with `editable` set. The scene must
// not be used during the call. Uses TBB. Throws InputError for an invalid texture, leaving the
// scene unchanged.
//
// Unchanged parts are reused. Emitters are reused if their material emits as before; averaging an
// emissive texture over triangles is the most expensive part. The light sampler is reused if
// neither emitters nor punctual lights have changed. The tables of an environment are reused if it
// was only rotated, tinted or scaled. The result of the search for flush emitters is reused if the
// same triangles emit.
void update_scene(Scene& scene, const SceneDescription& description,
                  const SceneBuildOptions& options);

// Changes the scene to another pose of its file. The scene then renders bit-identically to one
// built from the complete `posed` description. Meshes that `posed` omits
// (MeshDescription::reused_bounds) are taken from the scene, with their BVHs. Rebuilds the BVHs of
// deforming meshes, of the top level, and of static meshes if an instance index has changed. If
// nothing has moved, this does the same as update_scene().
//
// Returns false if the pose needs another internal space or a mesh that the scene lacks; the caller
// must then build the scene from a complete description. The scene must not be used during the
// call; `scene` may point to another object afterwards. Throws like build_scene(). On an exception
// or false, the scene is unchanged.
bool repose_scene(std::unique_ptr<Scene>& scene, SceneDescription posed,
                  const SceneBuildOptions& options, LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
