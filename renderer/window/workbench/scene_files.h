// Reads and writes scenes, edits, environments and pictures for the user. Failures become messages.
//
// Used on the window's thread only. Scenes and pictures are read and written in the background;
// edits are read immediately.
#pragma once

#include <functional>
#include <future>
#include <string>
#include <vector>

#include "renderer/session/view_settings.h"

namespace emberline {

class Workbench;

class SceneFiles {
 public:
  // `options` names the first scene and its edits file.
  SceneFiles(const RenderOptions& options, Workbench& bench)
      : first_scene_(options.scene), first_edits_file_(options.edits), bench_(bench) {}

  void open(const std::string& scene);
  // Reads the scene's file again with the current loading options. Keeps the edits, the name of
  // their file and the bookmarks, but not the undo history.
  void reload();
  // Opens a dropped file: a scene, or an environment or an edits file for the open scene.
  void open_dropped(const std::string& path);
  // Call when the session has a new scene. Returns whether it was a reload.
  bool on_new_scene();

  void save_edits();
  void save_picture(const std::string& path);
  void save_heatmap(const std::string& path, ViewOverlay quantity);
  // Reports finished writes. Call whenever the window wakes up.
  void update();

  // Throws UsageError if `path` is an input file of the open scene.
  void check_output(const std::string& option, const std::string& path) const;

 private:
  struct PendingSave {
    std::future<void> done;
    std::string what;
    std::function<void()> after;
  };

  std::string edits_file() const;

  const std::string first_scene_, first_edits_file_;
  Workbench& bench_;
  bool reloading_ = false;
  std::string edits_file_, pending_edits_file_;  // empty if there is none
  std::vector<PendingSave> saves_;
};

}  // namespace emberline
