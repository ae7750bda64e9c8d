// Values that change while the shutter is open, from time 0 (open) to time 1 (close). The types are
// plain data with pure functions.
#pragma once

#include <algorithm>
#include <vector>

namespace emberline {

// A piecewise linear curve with at least one key, which is constant before its first and after its
// last key. Times are non-decreasing. Where two keys have the same time, the value jumps, and the
// second key applies from that time on.
template <class Value>
struct TimeCurve {
  std::vector<float> times;
  std::vector<Value> values;

  // Takes logarithmic time in the number of keys (binary search).
  Value at(float time) const {
    const auto next = size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
    if (next == 0) return values.front();
    if (next == times.size()) return values.back();
    const Value& before = values[next - 1];
    const float elapsed = time - times[next - 1];
    return before + (values[next] - before) * (elapsed / (times[next] - times[next - 1]));
  }
};

// Visibility over time. Each of `toggle_times` toggles the visibility.
struct VisibilityTimes {
  bool visible_at_open = true;
  std::vector<float> toggle_times;  // non-decreasing times

  bool at(float time) const {
    const auto toggle_count =
        std::upper_bound(toggle_times.begin(), toggle_times.end(), time) - toggle_times.begin();
    return visible_at_open != (toggle_count % 2 == 1);
  }
};

}  // namespace emberline
