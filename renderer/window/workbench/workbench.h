// The window's model, independent of any window library: the session, and one class for each task
// that changes what the session shows. Panels and input call these classes directly. Nothing here
// draws.
//
// Used on the window's thread only; nothing here blocks.
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

// Says which parts of the interface are open, and holds pending requests.
struct InterfaceState {
  bool show_shortcuts = false, show_messages = false;
  bool scene_dialog_requested = false, save_dialog_requested = false,
       environment_dialog_requested = false;  // requests to open a dialog
  bool quit = false, full_screen = false, screenshot_requested = false;
};

class Workbench {
 public:
  // `state` must outlive this object. The session's threads call `wake` when there is news for
  // update(). `copy_text` copies a text to the clipboard. Throws RenderError if the journal cannot
  // be written.
  Workbench(const ViewOptions& options, WindowState& state, std::function<void()> wake,
            std::function<void(const std::string&)> copy_text);
  ~Workbench();

  // Fetches updates from the session. Call whenever the window wakes up. Returns whether there is
  // something new to display. Throws UsageError if the journal is an input file of a new scene.
  bool update();
  // `held` says whether a control, mouse button or flight key is held. All changes until its
  // release form one undo step.
  void update_gesture(bool held);
  // `number` is the bookmark's number, for actions that store or recall a bookmark.
  void act(Action action, int number = 0);

  // Return the state at the last update().
  const LoadStatus& load_status() const { return load_status_; }
  const std::shared_ptr<const SessionPicture>& picture() const { return picture_; }

  WindowState& window;
  InterfaceState interface;
  PicturePlacement placement;
  Journal journal;
  EditLatency latency;
  MessageLog messages;
  RenderSession session;  // panels read it; the members below change it
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
  void report_failed_load();
  void accept_scene();
  bool update_picture();
  bool update_problem();

  std::shared_ptr<const ListedScene> scene_;  // the scene that the other members have adopted
  std::shared_ptr<const SessionPicture> picture_;
  LoadStatus load_status_;
  std::string problem_;
};

}  // namespace emberline
