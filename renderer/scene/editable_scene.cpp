#include "renderer/scene/editable_scene.h"

#include <utility>

namespace emberline {

EditableScene::EditableScene(SceneDescription description, SceneBuildOptions options,
                             LoadProgress& progress)
    : options_(options) {
  options_.editable = true;
  apply({}, description);  // adds the default light and material
  original_ = outline(description);
  scene_ = build_scene(std::move(description), options_, progress);
}

bool EditableScene::repose(SceneDescription posed, const SceneEdits& edits,
                           LoadProgress& progress) {
  apply({}, posed);
  SceneDescription original = outline(posed);
  apply(edits, posed);
  if (!repose_scene(scene_, std::move(posed), options_, progress)) return false;
  original_ = std::move(original);
  edits_ = edits;
  return true;
}

void EditableScene::set(const SceneEdits& edits) {
  SceneEdits as_seen_before = edits;
  as_seen_before.camera = edits_.camera;
  as_seen_before.animation = edits_.animation;
  if (as_seen_before != edits_) {
    SceneDescription edited = original_;
    apply(edits, edited);
    update_scene(*scene_, edited, options_);
  }
  edits_ = edits;
}

}  // namespace emberline
