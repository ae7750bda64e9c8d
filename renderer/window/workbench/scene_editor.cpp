#include "renderer/window/workbench/scene_editor.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/workbench/clock.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

void SceneEditor::on_new_scene(bool reread) {
  const SceneEdits before = history_.current();
  solo_.reset();
  if (!reread) saved_ = bench_.session.edits();
  if (reread && before != bench_.session.edits()) submit_edits(before, std::nullopt);
  history_ = EditHistory(bench_.session.edits());
}

void SceneEditor::change(const SceneEdits& edits, std::string_view what) {
  if (edits == bench_.session.edits() || !submit_edits(edits, solo_)) return;
  history_.record(edits, std::string(what));
  bench_.latency.add_edit(bench_.session.edit(), std::string(what), window_time_s());
}

template <class Change>
void SceneEditor::change_with(std::string_view what, Change change_it) {
  SceneEdits edits = bench_.session.edits();
  change_it(edits);
  change(edits, what);
}

void SceneEditor::change(const LightEdit& light, std::string_view what) {
  change_with(what, [&](SceneEdits& e) { store_entry(e, bench_.session.scene()->outline, light); });
}

void SceneEditor::change(const MaterialEdit& material, std::string_view what) {
  change_with(what,
              [&](SceneEdits& e) { store_entry(e, bench_.session.scene()->outline, material); });
}

void SceneEditor::change(const CameraEdit& camera, std::string_view what) {
  change_with(what, [&](SceneEdits& e) { e.camera = camera; });
}

void SceneEditor::change(const AnimationEdit& animation, std::string_view what) {
  change_with(what, [&](SceneEdits& e) { e.animation = animation; });
}

void SceneEditor::set_environment(const std::string& file) {
  change_with("environment file", [&](SceneEdits& e) {
    e.environment.file = file;
    e.environment.image.reset();
    e.environment.repaired_texels = 0;
  });
}

void SceneEditor::clear_environment() {
  const auto scene = bench_.session.scene();
  if (!scene) return;
  if (scene->outline.environment) return set_environment("");
  change_with("environment file", [](SceneEdits& e) {  // drop all edits of the added environment
    e.environment = {};
    std::erase_if(e.lights,
                  [](const LightEdit& light) { return light.kind == EditedLight::kEnvironment; });
  });
}

void SceneEditor::rotate_environment(double degrees) {
  const auto scene = bench_.session.scene();
  if (!scene) return;
  const std::optional<EnvironmentDescription>& own = scene->outline.environment;
  SceneEdits edits = bench_.session.edits();
  EnvironmentEdit& edit = edits.environment;
  if (!own && edit.file.empty()) {
    return bench_.messages.note("The scene has no environment to rotate");
  }
  const float before = edit.rotation_degrees.value_or(own ? own->rotation_degrees : 0.0f);
  edit.rotation_degrees = float(std::remainder(before + degrees, 360.0));
  change(edits, "environment rotation");
}

void SceneEditor::set_solo(const std::optional<LightEdit>& light) {
  if (light != solo_) submit_edits(bench_.session.edits(), light);
}

void SceneEditor::undo() {
  if (can_undo() && !submit_edits(history_.undo(), solo_)) history_.redo();
}

void SceneEditor::redo() {
  if (can_redo() && !submit_edits(history_.redo(), solo_)) history_.undo();
}

bool SceneEditor::has_unsaved_edits() const {
  return bench_.session.scene() && bench_.session.edits() != saved_;
}

// May be called for every mouse event: the session combines edits that come faster than pictures.
bool SceneEditor::submit_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo) {
  if (!bench_.session.scene()) return false;
  try {
    bench_.session.set_edits(edits, solo);
  } catch (const InputError& error) {
    bench_.messages.error(error.what());
    return false;
  }
  solo_ = solo;
  write_journal();
  return true;
}

void SceneEditor::write_journal() const {
  const SceneEdits& edits = bench_.session.edits();
  bench_.journal.write("edit", {{"edit", bench_.session.edit()}});
  const std::optional<Vec3d>& from = edits.camera.look_from;
  const std::optional<double>& height = edits.camera.orthographic_height;
  const std::optional<double>& time = edits.animation.time;
  const nlohmann::json camera = from ? nlohmann::json{from->x, from->y, from->z} : nlohmann::json();
  bench_.journal.write("edits",
                       {{"camera", camera},
                        {"orthographic_height", height ? nlohmann::json(*height) : nullptr},
                        {"mirrored", edits.camera.mirrored},
                        {"animation", edits.animation.name},
                        {"time", time ? nlohmann::json(*time) : nullptr},
                        {"environment", edits.environment.file},
                        {"lights", edits.lights.size()},
                        {"materials", edits.materials.size()}});
}

}  // namespace emberline
