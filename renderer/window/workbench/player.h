// Plays and steps through the open scene's animations. Each frame is an edit of
// SceneEdits::animation; frames are dropped if the session is too slow. Does nothing for a scene
// without animations.
//
// Used on the window's thread only; nothing here blocks.
#pragma once

#include "renderer/window/panels/time_line.h"
#include "renderer/window/workbench/scene_editor.h"

namespace emberline {

class Player {
 public:
  // Both arguments must outlive this object.
  Player(const RenderSession& session, SceneEditor& edits) : session_(session), edits_(edits) {}

  bool available() const;

  bool playing() const { return playback_.playing(); }
  void toggle_playing();
  void stop() { playback_.stop(); }
  void step(int frames);  // also stops playing
  bool is_looping() const { return playback_.loop; }
  void set_loop(bool loop) { playback_.loop = loop; }

  // Shows the frame that is due. Call whenever the window wakes up.
  void update();
  // Returns the window_time_s() at which the next frame is due, or 1e300 if not playing.
  double next_frame_s() const;

 private:
  const RenderSession& session_;
  SceneEditor& edits_;
  Playback playback_;
};

}  // namespace emberline
