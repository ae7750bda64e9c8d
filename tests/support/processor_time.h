// Measures the processor time of this process. It does not depend on what other processes do.
#pragma once

#include <chrono>
#include <ctime>
#include <thread>

namespace emberline::test {

// Returns the processor time of all threads together, in seconds.
inline double processor_seconds() {
  timespec t = {};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// Sleeps until the other threads of this process have used this much processor time.
inline void wait_for_work(double seconds) {
  for (const double end = processor_seconds() + seconds; processor_seconds() < end;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace emberline::test
