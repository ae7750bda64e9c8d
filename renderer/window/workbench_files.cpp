// What is opened and what is saved.
#include <chrono>
#include <filesystem>

#include "io/files/register.h"
#include "io/json/edits_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/window/workbench.h"

namespace emberline {

void Workbench::check_output(const std::string& option, const std::string& path) const {
  FileRegister files;
  files.write(option, path);
  if (scene_) files.read(scene_->inputs, "the scene reads");
  if (!edits_.environment.file.empty()) {
    files.read(edits_.environment.file, "it is the environment of the edits");
  }
}

void Workbench::open(const std::string& scene) {
  reloading_ = false;
  const bool first = !scene_ && scene == options_.render.scene;
  session_.open(scene, first ? options_.render.edits : std::string());
}

void Workbench::reload() {
  if (!scene_) return;
  session_.open(scene_->outline.file);
  reloading_ = true;
}

void Workbench::open_dropped(const std::string& path) {
  const std::string suffix = lower_suffix(path);
  if (suffix == ".hdr" || suffix == ".exr") {
    if (!scene_) return say(Message::Level::kError, path + ": open a scene first, then its light");
    return set_environment(path);
  }
  if (suffix == ".json") {
    if (!scene_) return say(Message::Level::kError, path + ": open a scene first, then its edits");
    try {
      change(read_edits(path), "edits file");
      edits_file_ = path;
    } catch (const EmberlineError& error) {
      say(Message::Level::kError, error.what());
    }
    return;
  }
  open(path);
}

std::string Workbench::edits_file() const {
  if (!edits_file_.empty()) return edits_file_;
  std::filesystem::path scene = scene_->outline.file;
  return free_file(scene.replace_extension().string(), ".edits.json");
}

void Workbench::save_edits() {
  if (!scene_) return;
  edits_file_ = edits_file();
  saves_.push_back({session_.save_edits(edits_file_), "edits saved: " + edits_file_,
                    [this, saved = edits_] { saved_edits_ = saved; }});
}

void Workbench::save_picture(const std::string& path) {
  saves_.push_back({session_.save(path), "picture saved: " + path, {}});
}

void Workbench::save_heatmap(const std::string& path, ViewOverlay quantity) {
  try {
    saves_.push_back({session_.save_heatmap(path, quantity), "heatmap saved: " + path, {}});
  } catch (const EmberlineError& error) {
    say(Message::Level::kError, error.what());
  }
}

void Workbench::finish_saves() {
  std::erase_if(saves_, [&](PendingSave& save) {
    if (save.done.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    try {
      save.done.get();
      if (save.after) save.after();
      say(Message::Level::kNote, save.what);
    } catch (const std::exception& error) {
      say(Message::Level::kError, error.what());
    }
    return true;
  });
}

}  // namespace emberline
