// The time of the scene, and what plays.
#include "renderer/window/workbench.h"

namespace emberline {

void Workbench::change_animation(const AnimationEdit& animation, std::string_view what) {
  SceneEdits edits = edits_;
  edits.animation = animation;
  change(edits, what);
}

void Workbench::play() {
  if (!has_time_line()) return;
  if (playback.playing()) return playback.stop();
  const AnimationEdit& edit = edits_.animation;
  const double time = edit.time.value_or(0.0);
  playback.start(time < duration_of(edit, scene_->animations) ? time : 0.0, now());
}

void Workbench::step(int frames) {
  if (!has_time_line()) return;
  playback.stop();
  AnimationEdit edit = edits_.animation;
  edit.time =
      stepped(edit.time.value_or(0.0), frames, fps_of(edit), duration_of(edit, scene_->animations));
  change_animation(edit, "frame");
}

// The session leaves out what it is too slow for.
void Workbench::play_on() {
  if (!playback.playing()) return;
  if (!has_time_line()) return playback.stop();
  AnimationEdit edit = edits_.animation;
  edit.time = playback.time_at(now(), fps_of(edit), duration_of(edit, scene_->animations));
  change_animation(edit, "play");
}

double Workbench::next_frame_s() const {
  const double fps = fps_of(edits_.animation);
  return playback.playing() ? now() + 1.0 / fps : 1e300;
}

}  // namespace emberline
