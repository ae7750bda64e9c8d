#include "renderer/window/workbench/player.h"

#include "renderer/window/workbench/clock.h"

namespace emberline {

bool Player::available() const {
  const auto scene = session_.scene();
  return scene && !scene->animations.empty();
}

void Player::toggle_playing() {
  if (!available()) return;
  if (playing()) return stop();
  const AnimationEdit& edit = session_.edits().animation;
  const double time = edit.time.value_or(0.0);
  const double duration = duration_of(edit, session_.scene()->animations);
  playback_.start(time < duration ? time : 0.0, window_time_s());
}

void Player::step(int frames) {
  if (!available()) return;
  stop();
  AnimationEdit edit = session_.edits().animation;
  const double duration = duration_of(edit, session_.scene()->animations);
  edit.time = step_time(edit.time.value_or(0.0), frames, fps_of(edit), duration);
  edits_.change(edit, "frame");
}

void Player::update() {
  if (!playing()) return;
  if (!available()) return stop();
  AnimationEdit edit = session_.edits().animation;
  const double duration = duration_of(edit, session_.scene()->animations);
  edit.time = playback_.time_at(window_time_s(), fps_of(edit), duration);
  edits_.change(edit, "play");
}

double Player::next_frame_s() const {
  return playing() ? window_time_s() + 1.0 / fps_of(session_.edits().animation) : 1e300;
}

}  // namespace emberline
