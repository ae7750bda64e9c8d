#include "renderer/window/workbench/workbench.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/workbench/clock.h"

namespace emberline {
namespace {

ViewSettings first_settings(const ViewOptions& options) {
  ViewSettings settings;
  settings.render = options.render;
  settings.display = options.render.display;
  settings.denoise = true;
  settings.light_groups = options.render.light_groups;
  settings.render.heatmap_style.colours = ColourMap::kViridis;
  return settings;
}

}  // namespace

Workbench::Workbench(const ViewOptions& options, WindowState& state, std::function<void()> wake,
                     std::function<void(const std::string&)> copy_text)
    : window(state),
      messages(journal),
      session(first_settings(options)),
      edits(*this),
      settings(session, latency, journal),
      navigator(*this),
      player(session, edits),
      pixels(*this, std::move(copy_text)),
      comparison(*this),
      files(options.render, *this) {
  const std::string& scene = options.render.scene;
  if (!options.journal.empty()) journal.open_later(options.journal);
  if (journal.is_buffering() && scene.empty()) journal.begin();
  session.on_change(std::move(wake));
  if (!scene.empty()) files.open(scene);
}

Workbench::~Workbench() { session.on_change({}); }

bool Workbench::update() {
  bool changed = update_load_status();
  if (session.scene() != scene_) accept_scene();
  changed |= update_picture();
  changed |= comparison.update();
  player.update();
  files.update();
  changed |= update_problem();
  changed |= pixels.update();
  return messages.poll_changed() || changed;
}

bool Workbench::update_load_status() {
  const LoadStatus before = std::exchange(load_status_, session.load_status());
  const bool changed = before.state != load_status_.state;
  if (load_status_.state == LoadStatus::State::kFailed &&
      (changed || before.error != load_status_.error)) {
    report_failed_load();
  }
  return changed || before.fraction != load_status_.fraction || before.stage != load_status_.stage;
}

void Workbench::report_failed_load() {
  messages.error(load_status_.error);
  // Since loading failed, the scene's input files are not known. Only a journal file that is new or
  // empty is certainly not one of them.
  std::error_code none;
  const auto size = std::filesystem::file_size(journal.path(), none);
  if (journal.is_buffering() && (none || size == 0)) journal.begin();
}

void Workbench::accept_scene() {
  scene_ = session.scene();
  window.remember_scene(load_status_.path);
  if (journal.is_buffering()) {
    files.check_output("`journal`", journal.path());
    journal.begin();
  }
  for (const std::string& warning : scene_->warnings) messages.warning(warning);
  journal.write("scene", {{"file", load_status_.path},
                          {"materials", scene_->outline.materials.size()},
                          {"lights", list_lights(scene_->outline, session.edits()).size()}});
  const bool reread = files.on_new_scene();
  player.stop();
  navigator.on_new_scene(reread);
  pixels.on_new_scene();
  edits.on_new_scene(reread);
  latency.add_edit(session.edit(), "open", window_time_s());
}

bool Workbench::update_picture() {
  std::shared_ptr<const SessionPicture> picture = session.picture();
  if (picture == picture_) return false;
  picture_ = std::move(picture);
  return true;
}

bool Workbench::update_problem() {
  std::string problem = session.problem();
  if (problem == problem_) return false;
  problem_ = std::move(problem);
  if (!problem_.empty()) messages.error(problem_);
  return true;
}

// Like a drag, playback forms one undo step.
void Workbench::update_gesture(bool held) {
  if (!held && !player.playing()) edits.end_gesture();
}

}  // namespace emberline
