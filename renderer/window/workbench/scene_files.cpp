#include "renderer/window/workbench/scene_files.h"

#include <chrono>
#include <filesystem>
#include <utility>

#include "io/files/register.h"
#include "io/json/edits_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/window/window_state.h"

namespace emberline {

SceneFiles::SceneFiles(const RenderOptions& options, RenderSession& session, SceneEditor& edits,
                       MessageLog& messages)
    : first_scene_(options.scene),
      first_edits_file_(options.edits),
      session_(session),
      edits_(edits),
      messages_(messages) {}

void SceneFiles::open(const std::string& scene) {
  reloading_ = false;
  const bool first = !session_.scene() && scene == first_scene_;
  arriving_edits_file_ = first ? first_edits_file_ : std::string();
  session_.open(scene, arriving_edits_file_);
}

void SceneFiles::reload() {
  const auto scene = session_.scene();
  if (!scene) return;
  session_.open(scene->outline.file);
  reloading_ = true;
}

bool SceneFiles::scene_arrived() {
  const bool reread = std::exchange(reloading_, false);
  if (!reread) edits_file_ = arriving_edits_file_;
  return reread;
}

void SceneFiles::open_dropped(const std::string& path) {
  const std::string suffix = lower_suffix(path);
  const bool open_scene = session_.scene() != nullptr;
  if (suffix == ".hdr" || suffix == ".exr") {
    if (!open_scene) return messages_.error(path + ": open a scene first, then its light");
    return edits_.set_environment(path);
  }
  if (suffix != ".json") return open(path);
  if (!open_scene) return messages_.error(path + ": open a scene first, then its edits");
  try {
    edits_.change(read_edits(path), "edits file");
    edits_file_ = path;
  } catch (const EmberlineError& error) {
    messages_.error(error.what());
  }
}

// The file that the edits were read from or saved to; if there is none, a new name.
std::string SceneFiles::edits_file() const {
  if (!edits_file_.empty()) return edits_file_;
  std::filesystem::path scene = session_.scene()->outline.file;
  return free_file(scene.replace_extension().string(), ".edits.json");
}

void SceneFiles::save_edits() {
  if (!session_.scene()) return;
  edits_file_ = edits_file();
  saves_.push_back({session_.save_edits(edits_file_), "edits saved: " + edits_file_,
                    [this, saved = session_.edits()] { edits_.note_saved(saved); }});
}

void SceneFiles::save_picture(const std::string& path) {
  saves_.push_back({session_.save(path), "picture saved: " + path, {}});
}

void SceneFiles::save_heatmap(const std::string& path, ViewOverlay quantity) {
  try {
    saves_.push_back({session_.save_heatmap(path, quantity), "heatmap saved: " + path, {}});
  } catch (const EmberlineError& error) {
    messages_.error(error.what());
  }
}

void SceneFiles::update() {
  std::erase_if(saves_, [&](PendingSave& save) {
    if (save.done.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    try {
      save.done.get();
      if (save.after) save.after();
      messages_.note(save.what);
    } catch (const std::exception& error) {
      messages_.error(error.what());
    }
    return true;
  });
}

void SceneFiles::check_output(const std::string& option, const std::string& path) const {
  FileRegister files;
  files.write(option, path);
  if (const auto scene = session_.scene()) files.read(scene->inputs, "the scene reads");
  const std::string& environment = session_.edits().environment.file;
  if (!environment.empty()) files.read(environment, "it is the environment of the edits");
}

}  // namespace emberline
