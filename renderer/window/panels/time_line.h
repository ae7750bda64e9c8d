// The arithmetic of a time line, and what plays on it. Knows no window.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// What an edit means to a file's animations. Without a time and a name the scene is at rest.
inline bool is_at_rest(const AnimationEdit& edit) { return !edit.time && edit.name.empty(); }
// Their place in the list; -1 for all of them, or at rest. The first, where the edit names none.
int animation_index(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);
// What an edit calls one: its name, or its index where another has that name, or it has none.
std::string animation_name(size_t index, const std::vector<AnimationDescription>& list);
// Seconds until the last key frame of what is chosen; of the first, at rest.
double duration_of(const AnimationEdit& edit, const std::vector<AnimationDescription>& list);

inline constexpr double kOrdinaryFps = 24.0;
inline double fps_of(const AnimationEdit& edit) { return edit.fps.value_or(kOrdinaryFps); }
// The last whole frame that begins at or before a time; and where so many frames on from there is
// within the duration.
double frame_at(double time, double fps);
double stepped(double time, double frames, double fps, double duration);

// What plays. `now`: seconds of a clock that goes on evenly.
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
