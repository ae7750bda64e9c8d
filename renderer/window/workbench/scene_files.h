// Reads and writes files for the user: scenes, edits, environments, pictures. A failure becomes a
// message.
//
// The window's thread only. Nothing here waits for a picture or a scene: those are read and written
// in the background. Edits are read at once.
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
  // `options` name the first scene and its edits.
  SceneFiles(const RenderOptions& options, Workbench& bench)
      : first_scene_(options.scene), first_edits_file_(options.edits), bench_(bench) {}

  void open(const std::string& scene);
  // Reads the scene's file again, with the settings' options of loading as they now are. Edits,
  // bookmarks and the file of the edits stay; the history of the edits does not.
  void reload();
  // A scene; or an environment or edits for the open one.
  void open_dropped(const std::string& path);
  // The session has a new scene. True if it is a file that was read again.
  bool scene_arrived();

  void save_edits();
  void save_picture(const std::string& path);
  void save_heatmap(const std::string& path, ViewOverlay quantity);
  // Tells which files have been written. Called each time that the window wakes up.
  void update();

  // Throws UsageError where `option`'s file is one that the open scene was read from.
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
  std::string edits_file_, arriving_edits_file_;  // empty: none yet
  std::vector<PendingSave> saves_;
};

}  // namespace emberline
