// Arithmetic of the time line, and playback. Needs no window library.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// Whether the edit sets neither a time nor an animation, so that the scene is not animated.
inline bool is_unanimated(const AnimationEdit& edit) { return !edit.time && edit.name.empty(); }
// Index of the edit's animation in `list`. -1 if it selects all or if the scene is not animated; 0
// if it sets only a time.
int animation_index(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);
// The animation's name for AnimationEdit: its own, or its index if an animation before it has the
// same name or if it has none.
std::string animation_name(size_t index, const std::vector<AnimationDescription>& list);
// Time of the last key frame in seconds: of the chosen animation; of the first if the scene is not
// animated; the latest if the edit selects all.
double duration_of(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);

inline constexpr double kDefaultFps = 24.0;
inline double fps_of(const AnimationEdit& edit) { return edit.fps.value_or(kDefaultFps); }
// frame_at() returns the last whole frame that begins at or before `time`. step_time() returns the
// time of the frame that is `frames` after that, clamped to the duration.
double frame_at(double time, double fps);
double step_time(double time, double frames, double fps, double duration);

// Plays animations. `now` is the time of a steady clock in seconds.
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
  double start_ = 0.0;  // time of the clock at which animation time was 0
};

}  // namespace emberline
