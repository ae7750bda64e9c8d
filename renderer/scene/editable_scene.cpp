#include "renderer/scene/editable_scene.h"

#include <utility>

namespace emberline {

EditableScene::EditableScene(SceneDescription description, SceneBuildOptions options,
                             LoadProgress& progress)
    : options_(options) {
  options_.editable = true;
  apply({}, description);  // adds the default light and material
  original_ = copy_without_geometry(description);
  scene_ = build_scene(std::move(description), options_, progress);
}

bool EditableScene::repose(SceneDescription posed, const SceneEdits& edits,
                           LoadProgress& progress) {
  apply({}, posed);
  SceneDescription original = copy_without_geometry(posed);
  apply(edits, posed);
  if (!repose_scene(scene_, std::move(posed), options_, progress)) return false;
  original_ = std::move(original);
  edits_ = edits;
  return true;
}

void EditableScene::set(const SceneEdits& edits) {
  SceneEdits with_previous_view = edits;
  with_previous_view.camera = edits_.camera;
  with_previous_view.animation = edits_.animation;
  if (with_previous_view != edits_) {
    SceneDescription edited = original_;
    apply(edits, edited);
    update_scene(*scene_, edited, options_);
  }
  edits_ = edits;
}

}  // namespace emberline
