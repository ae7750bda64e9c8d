// The arithmetic of a time line, and what plays on it. Knows no window.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// The meaning of an edit for a file's animations. Without time and name the scene is at rest.
inline bool is_at_rest(const AnimationEdit& edit) { return !edit.time && edit.name.empty(); }
// The animation's index in the list: -1 for all, or at rest; 0 if the edit names none.
int animation_index(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);
// An animation's name in edits: its own, or its index if that is not unique or missing.
std::string animation_name(size_t index, const std::vector<AnimationDescription>& list);
// Seconds until the last key frame of the chosen animation; of the first one, at rest.
double duration_of(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);

inline constexpr double kOrdinaryFps = 24.0;
inline double fps_of(const AnimationEdit& edit) { return edit.fps.value_or(kOrdinaryFps); }
// frame_at(): the last whole frame that begins at or before a time. stepped(): the time this number
// of frames later, within the duration.
double frame_at(double time, double fps);
double stepped(double time, double frames, double fps, double duration);

// Plays animations. `now`: seconds of a steady clock.
class Playback {
 public:
  void start(double time, double now);
  void stop() { playing_ = false; }
  bool playing() const { return playing_; }
  // The frame that is due: one at a time, the latest. Stops at the end, unless it loops.
  double time_at(double now, double fps, double duration);

  bool loop = true;

 private:
  bool playing_ = false;
  double began_ = 0.0;  // on the clock, when the time was 0
};

}  // namespace emberline
