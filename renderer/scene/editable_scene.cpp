#include "renderer/scene/editable_scene.h"

#include <utility>

namespace emberline {

EditableScene::EditableScene(SceneDescription description, SceneBuildOptions options,
                             LoadProgress& progress)
    : options_(options) {
  options_.editable = true;
  apply({}, description);  // the light and the material that the file leaves to its reader
  original_ = outline(description);
  scene_ = build_scene(std::move(description), options_, progress);
}

void EditableScene::set(const SceneEdits& edits) {
  SceneEdits as_seen_before = edits;
  as_seen_before.camera = edits_.camera;
  if (as_seen_before != edits_) {
    SceneDescription edited = original_;
    apply(edits, edited);
    update_scene(*scene_, edited, options_);
  }
  edits_ = edits;
}

}  // namespace emberline
