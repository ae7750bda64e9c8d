#include "renderer/scene/editable_scene.h"

#include <utility>

namespace emberline {

EditableScene::EditableScene(SceneDescription description, SceneBuildOptions options,
                             LoadProgress& progress)
    : options_(options) {
  options_.editable = true;
  apply({}, description);  // the light and the material that the file leaves to its reader
  original_ = outline(description);
  edited_ = original_;
  scene_ = build_scene(std::move(description), options_, progress);
}

EditClass EditableScene::set(const SceneEdits& edits) {
  const EditClass change = classify(edits_, edits);
  if (change >= EditClass::kLight) {
    SceneDescription edited = original_;
    apply(edits, edited);
    update_scene(*scene_, edited, options_);
    edited_ = std::move(edited);
  }
  edits_ = edits;
  return change;
}

}  // namespace emberline
