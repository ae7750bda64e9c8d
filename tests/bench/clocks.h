// Clocks in seconds, and the spread of several measurements.
#pragma once

#include <time.h>

#include <algorithm>
#include <vector>

namespace emberline::bench {

inline double seconds_of(clockid_t clock) {
  timespec now = {};
  clock_gettime(clock, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}
inline double process_cpu() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }
inline double thread_cpu() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }
inline double wall_clock() { return seconds_of(CLOCK_MONOTONIC); }

// Median, minimum and maximum.
struct Spread {
  double median = 0, minimum = 0, maximum = 0;
};
inline Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const size_t n = values.size();
  return {(values[(n - 1) / 2] + values[n / 2]) / 2, values.front(), values.back()};
}

}  // namespace emberline::bench
