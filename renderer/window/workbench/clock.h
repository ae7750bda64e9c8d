// The window's clock.
#pragma once

namespace emberline {

// Seconds since the first call; steady. Any thread.
double window_time_s();

}  // namespace emberline
