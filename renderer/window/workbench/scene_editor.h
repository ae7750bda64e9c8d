// Edits the open scene, with undo and redo. RenderSession::edits() holds the edits.
//
// A change that the session rejects has no effect, and the user gets a message. Without a scene,
// changes have no effect. Used on the window's thread only; nothing here blocks.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "renderer/session/edit_history.h"
#include "renderer/session/render_session.h"

namespace emberline {

class Workbench;

class SceneEditor {
 public:
  explicit SceneEditor(Workbench& bench) : bench_(bench) {}

  // Call when the session has a new scene. Clears the history. `reread` says that the scene is the
  // same file, read again. The edits are then kept if they still fit.
  void on_new_scene(bool reread);

  // `what` names the control; changes with the same name during one gesture form one undo step.
  void change(const SceneEdits& edits, std::string_view what);
  void change(const LightEdit& light, std::string_view what);
  void change(const MaterialEdit& material, std::string_view what);
  void change(const CameraEdit& camera, std::string_view what);
  void change(const AnimationEdit& animation, std::string_view what);
  // Ends the gesture: the next change is a new undo step.
  void end_gesture() { history_.end_gesture(); }

  // Replaces the scene's environment. Edits of its strength and rotation are kept.
  void set_environment(const std::string& file);
  // Restores the environment that the scene was opened with, if any.
  void clear_environment();
  void rotate_environment(double degrees);

  // Switches off all lights except `light`; nullopt ends solo. Solo is neither saved nor undoable.
  void set_solo(const std::optional<LightEdit>& light);
  const std::optional<LightEdit>& solo() const { return solo_; }

  bool can_undo() const { return history_.can_undo(); }
  bool can_redo() const { return history_.can_redo(); }
  void undo();
  void redo();

  bool has_unsaved_edits() const;
  // Records that these edits have been saved.
  void mark_saved(const SceneEdits& edits) { saved_ = edits; }

 private:
  template <class Change>
  void change_with(std::string_view what, Change change_it);
  bool submit_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo);
  void write_journal() const;

  Workbench& bench_;
  EditHistory history_;  // its current step equals the session's edits
  SceneEdits saved_;
  std::optional<LightEdit> solo_;
};

}  // namespace emberline
