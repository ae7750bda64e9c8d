// Arithmetic of the time line, and playback. Needs no window library.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// Returns whether the edit sets neither a time nor an animation, so that the scene is not animated.
inline bool is_unanimated(const AnimationEdit& edit) { return !edit.time && edit.name.empty(); }
// Returns the index of the edit's animation in `list`: -1 if the edit selects all animations or the
// scene is not animated, 0 if the edit sets only a time.
int animation_index(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);
// Returns the text with which AnimationEdit::name selects the animation: its name, or its index if
// it has no name or an earlier animation has the same name.
std::string animation_name(size_t index, const std::vector<AnimationDescription>& list);
// Returns the duration of the chosen animation, which is the time of its last key frame in seconds.
// If the edit selects all animations, returns the longest duration. If the scene is not animated,
// returns the first animation's duration.
double duration_of(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);

inline constexpr double kDefaultFps = 24.0;
inline double fps_of(const AnimationEdit& edit) { return edit.fps.value_or(kDefaultFps); }
// frame_at() returns the last whole frame that begins at or before `time`. step_time() returns the
// time of the frame that is `frames` later, clamped to the duration.
double frame_at(double time, double fps);
double step_time(double time, double frames, double fps, double duration);

// Plays animations. `now` is a steady clock's time in seconds.
class Playback {
 public:
  void start(double time, double now);
  void stop() { playing_ = false; }
  bool playing() const { return playing_; }
  // Returns the animation time of the latest frame that is due. Stops at the end, or loops.
  double time_at(double now, double fps, double duration);

  bool loop = true;

 private:
  bool playing_ = false;
  double start_ = 0.0;  // the clock's time when the animation's time was 0
};

}  // namespace emberline
