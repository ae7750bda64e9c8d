// The window's clock.
#pragma once

#include <chrono>

namespace emberline {

// Returns the seconds since the first call, on a steady clock. May be called on any thread.
inline double window_time_s() {
  static const auto start = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace emberline
