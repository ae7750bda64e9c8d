// Adds edits of objects, which are given by index. For tests and benchmarks of edits.
#pragma once

#include "renderer/description/scene_edits.h"

namespace emberline::test {

inline MaterialEdit& material(SceneEdits& edits, int index) {
  MaterialEdit& edit = edits.materials.emplace_back();
  edit.target.index = index;
  return edit;
}

inline LightEdit& light(SceneEdits& edits, EditedLight kind, int index) {
  LightEdit& edit = edits.lights.emplace_back();
  edit.kind = kind;
  edit.target.index = index;
  return edit;
}

}  // namespace emberline::test
