// Everything that the window is about, without a window: the session, and the classes that change
// what it shows, each for a group of panels. Panels and input use those directly. Nothing here
// draws.
//
// The window's thread only; nothing here blocks it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "io/display/display.h"
#include "renderer/session/render_session.h"
#include "renderer/window/input/edit_latency.h"
#include "renderer/window/input/input.h"
#include "renderer/window/input/journal.h"
#include "renderer/window/picture/placement.h"
#include "renderer/window/view_command.h"
#include "renderer/window/window_state.h"
#include "renderer/window/workbench/comparison.h"
#include "renderer/window/workbench/message_log.h"
#include "renderer/window/workbench/navigator.h"
#include "renderer/window/workbench/pixel_inspector.h"
#include "renderer/window/workbench/player.h"
#include "renderer/window/workbench/scene_editor.h"
#include "renderer/window/workbench/scene_files.h"
#include "renderer/window/workbench/settings_editor.h"

namespace emberline {

// Open parts of the interface, and requests that are not carried out yet. Plain state.
struct InterfaceState {
  bool show_shortcuts = false, show_messages = false;
  bool ask_for_scene = false, ask_for_picture_file = false,
       ask_for_environment = false;  // a dialog is to be opened
  bool quit = false, full_screen = false, want_screenshot = false;
};

class Workbench {
 public:
  // `state` must outlive this. The session calls `wake`, from its own threads, when update() has
  // something to take in; `copy_text` puts a text on the clipboard. Throws RenderError for a
  // journal that cannot be written.
  Workbench(const ViewOptions& options, WindowState& state, std::function<void()> wake,
            std::function<void(const std::string&)> copy_text);
  ~Workbench();

  // Takes in what the session has brought. Called each time that the window wakes up. True if
  // there is something new to be seen. Throws UsageError where the journal is one of the files that
  // a new scene was read from.
  bool update();
  // A slider or the mouse is held: what is changed until it is let go is one step of undo.
  void gesture_goes_on(bool held);
  // `number`: of a bookmark.
  void act(Action action, int number = 0);

  // As of the last update().
  const LoadStatus& load_status() const { return load_status_; }
  const std::shared_ptr<const ShownPicture>& picture() const { return picture_; }

  WindowState& window;
  InterfaceState interface;
  PicturePlacement placement;
  Journal journal;
  EditLatency latency;
  MessageLog messages;
  RenderSession session;  // panels read it; what changes it are the following
  SceneEditor edits;
  SettingsEditor settings;
  Navigator navigator;
  Player player;
  MaterialSelection selection;
  PixelInspector pixels;
  Comparison comparison;
  SceneFiles files;
  const DisplayNames display_names = emberline::display_names();

 private:
  bool update_load_status();
  void note_failed_load();
  void take_scene();
  bool update_picture();
  bool update_problem();

  std::shared_ptr<const ListedScene> scene_;  // that the parts know
  std::shared_ptr<const ShownPicture> picture_;
  LoadStatus load_status_;
  std::string problem_;
};

}  // namespace emberline
