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
  if (!options.journal.empty()) journal.wait(options.journal);
  if (journal.waits() && scene.empty()) journal.begin();
  session.on_change(std::move(wake));
  if (!scene.empty()) files.open(scene);
}

Workbench::~Workbench() { session.on_change({}); }

bool Workbench::update() {
  bool news = update_load_status();
  if (session.scene() != scene_) take_scene();
  news |= update_picture();
  news |= comparison.update();
  player.update();
  files.update();
  news |= update_problem();
  news |= pixels.update();
  return messages.take_news() || news;
}

bool Workbench::update_load_status() {
  const LoadStatus before = std::exchange(load_status_, session.load_status());
  const bool changed = before.state != load_status_.state;
  if (load_status_.state == LoadStatus::State::kFailed &&
      (changed || before.error != load_status_.error)) {
    note_failed_load();
  }
  return changed || before.fraction != load_status_.fraction || before.stage != load_status_.stage;
}

void Workbench::note_failed_load() {
  messages.error(load_status_.error);
  // Unknown inputs: only a new or empty journal file is certainly not one of the scene's files.
  std::error_code none;
  const auto size = std::filesystem::file_size(journal.path(), none);
  if (journal.waits() && (none || size == 0)) journal.begin();
}

void Workbench::take_scene() {
  scene_ = session.scene();
  window.remember_scene(load_status_.path);
  if (journal.waits()) {
    files.check_output("`journal`", journal.path());
    journal.begin();
  }
  for (const std::string& warning : scene_->warnings) messages.warning(warning);
  journal.write("scene", {{"file", load_status_.path},
                          {"materials", scene_->outline.materials.size()},
                          {"lights", list_lights(scene_->outline, session.edits()).size()}});
  const bool reread = files.scene_arrived();
  player.stop();
  navigator.scene_arrived(reread);
  pixels.scene_arrived();
  edits.scene_arrived(reread);
  latency.asked(session.edit(), "open", window_time_s());
}

bool Workbench::update_picture() {
  std::shared_ptr<const ShownPicture> picture = session.picture();
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

// Playback forms one undo step, like a drag.
void Workbench::gesture_goes_on(bool held) {
  if (!held && !player.playing()) edits.end_gesture();
}

}  // namespace emberline
