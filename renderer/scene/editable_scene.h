// A built scene that follows edits without building its BVH anew: what a window renders.
//
// An edited scene renders the same bits as one built from the edited description. What of a
// material the BVH knows is its filter (geometry.h): whether back faces are culled, which
// transmission switches off, and whether there is coverage, which comes and goes with variants.
// Here the filter asks the mesh at every candidate hit for what may change, so that none of it
// touches the BVH: for culling wherever a material that the mesh may wear is single-sided, for
// coverage where one of several has alpha.
#pragma once

#include <memory>

#include "renderer/description/scene_edits.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/scene.h"

namespace emberline {

class EditableScene {
 public:
  // Builds the description without edits; throws as build_scene does. For variants to be chosen,
  // load it with GltfOptions::variants. Attributes of vertices that
  // no material reads yet are kept, for the edit that makes one read them.
  explicit EditableScene(SceneDescription description, SceneBuildOptions options = {},
                         LoadProgress& progress = LoadProgress::unwatched());

  // The whole of what differs from the file from now on: pass the edits of before to undo. The
  // camera's change nothing here, nor does
  // the animation's (repose()). Nobody else may use scene() meanwhile. Throws as apply() does,
  // and InputError for a texture that an edit brings into use and that cannot be; all is then as it
  // was.
  void set(const SceneEdits& edits);
  // Another pose of the file, with these edits: repose_scene, which see. scene() may be another
  // object then. Where it throws or says false all is as it was.
  bool repose(SceneDescription posed, const SceneEdits& edits,
              LoadProgress& progress = LoadProgress::unwatched());

  const Scene& scene() const { return *scene_; }
  const SceneEdits& edits() const { return edits_; }
  // The file's lists in this pose, which EditTarget counts in.
  const SceneDescription& original() const { return original_; }

 private:
  SceneBuildOptions options_;
  SceneDescription original_;  // an outline
  SceneEdits edits_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace emberline
