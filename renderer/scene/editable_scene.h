// A built scene that follows edits without rebuilding its BVH, for interactive rendering.
//
// An edited scene renders bit-identically to one built from the edited description. The BVH depends
// on materials only through its filter (geometry.h), which culls back faces and tests coverage.
// Edits can change both: transmission turns culling off, and a variant may assign a material with
// alpha. So the filter of an editable scene looks up in the mesh, at every candidate hit, whether
// to cull if the mesh may get a single-sided material, and whether to test coverage if the mesh has
// several possible materials of which one has alpha.
#pragma once

#include <memory>

#include "renderer/description/scene_edits.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/scene.h"

namespace emberline {

class EditableScene {
 public:
  // Builds the scene without edits; throws like build_scene(). If variants may be selected, load
  // the description with GltfOptions::variants. Vertex attributes that no material reads yet are
  // kept for later edits.
  explicit EditableScene(SceneDescription description, SceneBuildOptions options = {},
                         LoadProgress& progress = LoadProgress::none());

  // Replaces all current edits; to undo a change, pass the previous edits. Camera and animation
  // edits have no effect here (see repose()). scene() must not be used during the call. Throws like
  // apply(), and InputError for an invalid texture that an edit starts to use; the scene is then
  // unchanged.
  void set(const SceneEdits& edits);
  // Changes to another pose of the file, with these edits (see repose_scene()). scene() may be
  // another object afterwards. On an exception or false, the scene is unchanged.
  bool repose(SceneDescription posed, const SceneEdits& edits,
              LoadProgress& progress = LoadProgress::none());

  const Scene& scene() const { return *scene_; }
  const SceneEdits& edits() const { return edits_; }
  // Returns the description of the file in this pose, without edits or geometry. EditTarget indices
  // refer to its lists.
  const SceneDescription& original() const { return original_; }

 private:
  SceneBuildOptions options_;
  SceneDescription original_;  // without geometry
  SceneEdits edits_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace emberline
