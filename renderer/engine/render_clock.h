// Measures render time, excluding observers.
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

// Wall and CPU time of all threads, excluding exclude_time().
class RenderClock {
 public:
  double seconds() const { return wall_.seconds() - left_out_s_; }
  double cpu_seconds() const { return process_cpu_seconds() - cpu_before_; }
  double left_out_seconds() const { return left_out_s_; }
  template <typename Work>
  void exclude_time(const Work& work) {
    const double wall = wall_.seconds(), cpu = process_cpu_seconds();
    work();
    left_out_s_ += wall_.seconds() - wall;
    cpu_before_ += process_cpu_seconds() - cpu;
  }

 private:
  Stopwatch wall_;
  double cpu_before_ = process_cpu_seconds();
  double left_out_s_ = 0;
};

}  // namespace emberline
