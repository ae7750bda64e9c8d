// Time-line arithmetic and playback, independent of the window.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// Whether the edit names neither time nor animation, so that the scene is not animated.
inline bool is_unanimated(const AnimationEdit& edit) { return !edit.time && edit.name.empty(); }
// Index of the animation: -1 for all, or if the scene is not animated; 0 if the edit names none.
int animation_index(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);
// The animation's name in edits: its own, or its index if the name is missing or not unique.
std::string animation_name(size_t index, const std::vector<AnimationDescription>& list);
// Seconds to the last key frame of the chosen animation, or of the first if the scene is not
// animated.
double duration_of(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);

inline constexpr double kDefaultFps = 24.0;
inline double fps_of(const AnimationEdit& edit) { return edit.fps.value_or(kDefaultFps); }
// frame_at(): the last whole frame that begins at or before `time`. step_time(): the time `frames`
// frames later, within the duration.
double frame_at(double time, double fps);
double step_time(double time, double frames, double fps, double duration);

// Plays animations. `now` is in seconds of a steady clock.
class Playback {
 public:
  void start(double time, double now);
  void stop() { playing_ = false; }
  bool playing() const { return playing_; }
  // The time of the latest frame that is due. Stops at the end unless it loops.
  double time_at(double now, double fps, double duration);

  bool loop = true;

 private:
  bool playing_ = false;
  double start_ = 0.0;  // clock time of animation time 0
};

}  // namespace emberline
