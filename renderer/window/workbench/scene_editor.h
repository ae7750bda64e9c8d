// Edits of the open scene, with undo and redo. The edits themselves are RenderSession::edits().
//
// A change that the session refuses becomes a message, and everything stays as it was. Without a
// scene nothing is changed. The window's thread only; nothing here blocks it.
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

  // The session has a new scene. `reread`: it is the same file again, and the edits of before are
  // kept where they still fit; the history is not.
  void scene_arrived(bool reread);

  // `what` names the control that changes something: changes by one control during one gesture are
  // one step of undo.
  void change(const SceneEdits& edits, std::string_view what);
  void change(const LightEdit& light, std::string_view what);
  void change(const MaterialEdit& material, std::string_view what);
  void change(const CameraEdit& camera, std::string_view what);
  void change(const AnimationEdit& animation, std::string_view what);
  // Ends the gesture: the next change is a step of its own.
  void end_gesture() { history_.end_gesture(); }

  // An environment in place of the scene's. Its edited strength and rotation stay.
  void set_environment(const std::string& file);
  // Back to the environment that the scene was opened with, or to none.
  void clear_environment();
  void turn_environment(double degrees);

  // Only this light shines. It is not saved and not undone.
  void set_solo(const std::optional<LightEdit>& light);
  const std::optional<LightEdit>& solo() const { return solo_; }

  bool can_undo() const { return history_.can_undo(); }
  bool can_redo() const { return history_.can_redo(); }
  void undo();
  void redo();

  bool unsaved() const;
  // These edits are in a file now.
  void note_saved(const SceneEdits& edits) { saved_ = edits; }

 private:
  template <class Change>
  void change_with(std::string_view what, Change change_it);
  bool send(const SceneEdits& edits, const std::optional<LightEdit>& solo);
  void write_journal() const;

  Workbench& bench_;
  EditHistory history_;  // its current step is what the session has
  SceneEdits saved_;
  std::optional<LightEdit> solo_;
};

}  // namespace emberline
