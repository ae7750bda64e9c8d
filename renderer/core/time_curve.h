// What changes while the shutter is open, at times of its own: 0 opens it, 1 closes it. Plain data
// and pure functions.
#pragma once

#include <algorithm>
#include <vector>

namespace emberline {

// Values at times that do not fall, one at least, and straight lines between them; before the first
// and behind the last its value. Where two have one time it jumps: the later counts from then on.
template <class Value>
struct TimeCurve {
  std::vector<float> times;
  std::vector<Value> values;

  // Takes the logarithm of their number.
  Value at(float time) const {
    const auto behind = size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
    if (behind == 0) return values.front();
    if (behind == times.size()) return values.back();
    const Value& before = values[behind - 1];
    const float since = time - times[behind - 1];
    return before + (values[behind] - before) * (since / (times[behind] - times[behind - 1]));
  }
};

// When a thing is there: it comes and goes in turn.
struct ShownTimes {
  bool at_opening = true;
  std::vector<float> changes;  // which do not fall

  bool at(float time) const {
    const auto passed = std::upper_bound(changes.begin(), changes.end(), time) - changes.begin();
    return at_opening != (passed % 2 == 1);
  }
};

}  // namespace emberline
