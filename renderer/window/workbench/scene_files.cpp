#include "renderer/window/workbench/scene_files.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include "io/files/register.h"
#include "io/json/edits_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/window/window_state.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

void SceneFiles::open(const std::string& scene) {
  reloading_ = false;
  const bool first = !bench_.session.scene() && scene == first_scene_;
  pending_edits_file_ = first ? first_edits_file_ : std::string();
  bench_.session.open(scene, pending_edits_file_);
}

void SceneFiles::reload() {
  const auto scene = bench_.session.scene();
  if (!scene) return;
  bench_.session.open(scene->outline.file);
  reloading_ = true;
}

bool SceneFiles::on_new_scene() {
  const bool reread = std::exchange(reloading_, false);
  if (!reread) edits_file_ = pending_edits_file_;
  return reread;
}

void SceneFiles::open_dropped(const std::string& path) {
  const std::string suffix = lower_suffix(path);
  const bool open_scene = bench_.session.scene() != nullptr;
  if (suffix == ".hdr" || suffix == ".exr") {
    if (!open_scene) return bench_.messages.error(path + ": open a scene before its environment");
    return bench_.edits.set_environment(path);
  }
  if (suffix != ".json") return open(path);
  if (!open_scene) return bench_.messages.error(path + ": open a scene before its edits");
  try {
    bench_.edits.change(read_edits(path), "edits file");
    edits_file_ = path;
  } catch (const EmberlineError& error) {
    bench_.messages.error(error.what());
  }
}

// Returns the file that the edits were read from or saved to, or else a new name.
std::string SceneFiles::edits_file() const {
  if (!edits_file_.empty()) return edits_file_;
  std::filesystem::path scene = bench_.session.scene()->outline.file;
  return unused_file_name(scene.replace_extension().string(), ".edits.json");
}

void SceneFiles::save_edits() {
  if (!bench_.session.scene()) return;
  edits_file_ = edits_file();
  saves_.push_back({bench_.session.save_edits(edits_file_), "Edits saved: " + edits_file_,
                    [this, saved = bench_.session.edits()] { bench_.edits.mark_saved(saved); }});
}

void SceneFiles::save_picture(const std::string& path) {
  saves_.push_back({bench_.session.save(path), "Picture saved: " + path, {}});
}

void SceneFiles::save_heatmap(const std::string& path, ViewOverlay quantity) {
  try {
    saves_.push_back({bench_.session.save_heatmap(path, quantity), "Heatmap saved: " + path, {}});
  } catch (const EmberlineError& error) {
    bench_.messages.error(error.what());
  }
}

void SceneFiles::update() {
  std::erase_if(saves_, [&](PendingSave& save) {
    if (save.done.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    try {
      save.done.get();
      if (save.after) save.after();
      bench_.messages.note(save.what);
    } catch (const std::exception& error) {
      bench_.messages.error(error.what());
    }
    return true;
  });
}

void SceneFiles::check_output(const std::string& option, const std::string& path) const {
  FileRegister files;
  files.write(option, path);
  if (const auto scene = bench_.session.scene()) files.read(scene->inputs, "the scene reads");
  const std::string& environment = bench_.session.edits().environment.file;
  if (!environment.empty()) files.read(environment, "it is the environment of the edits");
}

}  // namespace emberline
