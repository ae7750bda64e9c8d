// Plays the open scene's animations, and steps through their frames. A frame is an edit of
// SceneEdits::animation; frames that the session is too slow for are left out. Does nothing for a
// scene without animations.
//
// The window's thread only; nothing here blocks it.
#pragma once

#include "renderer/window/panels/time_line.h"
#include "renderer/window/workbench/scene_editor.h"

namespace emberline {

class Player {
 public:
  // Both must outlive this.
  Player(const RenderSession& session, SceneEditor& edits) : session_(session), edits_(edits) {}

  // Whether the open scene has animations.
  bool available() const;

  bool playing() const { return playback_.playing(); }
  void play_or_stop();
  void stop() { playback_.stop(); }
  void step(int frames);  // stops, too
  bool loops() const { return playback_.loop; }
  void set_loop(bool loop) { playback_.loop = loop; }

  // Shows the frame that is due. Called each time that the window wakes up.
  void update();
  // window_time_s() when the next frame is due; without one, beyond all times.
  double next_frame_s() const;

 private:
  const RenderSession& session_;
  SceneEditor& edits_;
  Playback playback_;
};

}  // namespace emberline
