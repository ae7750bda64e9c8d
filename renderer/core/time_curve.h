// Values that change while the shutter is open, from time 0 (open) to time 1 (close). Plain data
// and pure functions.
#pragma once

#include <algorithm>
#include <vector>

namespace emberline {

// A piecewise linear curve with at least one key, constant before the first and after the last.
// Times are non-decreasing; at two equal times the value jumps, and the later key applies from then
// on.
template <class Value>
struct TimeCurve {
  std::vector<float> times;
  std::vector<Value> values;

  // Binary search, logarithmic in the number of keys.
  Value at(float time) const {
    const auto behind = size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
    if (behind == 0) return values.front();
    if (behind == times.size()) return values.back();
    const Value& before = values[behind - 1];
    const float since = time - times[behind - 1];
    return before + (values[behind] - before) * (since / (times[behind] - times[behind - 1]));
  }
};

// Visibility over time; each change toggles it.
struct ShownTimes {
  bool at_opening = true;
  std::vector<float> changes;  // non-decreasing times

  bool at(float time) const {
    const auto passed = std::upper_bound(changes.begin(), changes.end(), time) - changes.begin();
    return at_opening != (passed % 2 == 1);
  }
};

}  // namespace emberline
