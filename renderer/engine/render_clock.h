// Measures render time without the time that observers take.
#pragma once

#include <chrono>

#include "renderer/engine/process_usage.h"

namespace emberline {

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Measures wall time and the CPU time of all threads, excluding calls that are passed to
// exclude_time().
class RenderClock {
 public:
  double seconds() const { return wall_.seconds() - excluded_s_; }
  double cpu_seconds() const { return process_cpu_seconds() - cpu_before_; }
  double excluded_seconds() const { return excluded_s_; }
  template <typename Work>
  void exclude_time(const Work& work) {
    const double wall = wall_.seconds(), cpu = process_cpu_seconds();
    work();
    excluded_s_ += wall_.seconds() - wall;
    cpu_before_ += process_cpu_seconds() - cpu;
  }

 private:
  Stopwatch wall_;
  double cpu_before_ = process_cpu_seconds();
  double excluded_s_ = 0;
};

}  // namespace emberline
