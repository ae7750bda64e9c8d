#include "renderer/window/panels/time_line.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace emberline {
namespace {

// Tolerance, in frames, for rounding errors in the times of whole frames.
constexpr double kFrameTolerance = 1e-6;

}  // namespace

int animation_index(const AnimationEdit& edit, const std::vector<AnimationDescription>& list) {
  if (edit.name.empty()) return edit.time && !list.empty() ? 0 : -1;
  const auto named = std::ranges::find(list, edit.name, &AnimationDescription::name);
  if (named != list.end()) return int(named - list.begin());
  int index = -1;
  const char* const end = edit.name.data() + edit.name.size();
  const auto [stop, error] = std::from_chars(edit.name.data(), end, index);
  return error == std::errc() && stop == end && size_t(index) < list.size() ? index : -1;
}

std::string animation_name(size_t index, const std::vector<AnimationDescription>& list) {
  const std::string& name = list[index].name;
  const auto first = std::ranges::find(list, name, &AnimationDescription::name);
  const bool found = !name.empty() && size_t(first - list.begin()) == index;
  return found ? name : std::to_string(index);
}

double duration_of(const AnimationEdit& edit, const std::vector<AnimationDescription>& list) {
  if (list.empty()) return 0.0;
  if (is_unanimated(edit)) return list.front().duration;
  if (const int index = animation_index(edit, list); index >= 0) {
    return list[size_t(index)].duration;
  }
  double longest = 0.0;
  for (const AnimationDescription& animation : list) {
    longest = std::max(longest, animation.duration);
  }
  return longest;
}

double frame_at(double time, double fps) { return std::floor(time * fps + kFrameTolerance); }

double step_time(double time, double frames, double fps, double duration) {
  return std::clamp((frame_at(time, fps) + frames) / fps, 0.0, std::max(duration, 0.0));
}

void Playback::start(double time, double now) {
  playing_ = true;
  start_ = now - time;
}

double Playback::time_at(double now, double fps, double duration) {
  double time = std::max(now - start_, 0.0);
  if (time >= duration && !loop) stop();
  if (time >= duration && loop && duration > 0.0) {
    time = std::fmod(time, duration);
    start_ = now - time;
  }
  return std::min(frame_at(time, fps) / fps, std::max(duration, 0.0));
}

}  // namespace emberline
