#include "renderer/window/workbench/clock.h"

#include <chrono>

namespace emberline {

double window_time_s() {
  using Seconds = std::chrono::duration<double>;
  static const auto start = std::chrono::steady_clock::now();
  return Seconds(std::chrono::steady_clock::now() - start).count();
}

}  // namespace emberline
