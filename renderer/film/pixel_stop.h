// The values of the `stop` channel.
#pragma once

#include <cstdint>
#include <string>

namespace emberline {

// Why a pixel got no more samples.
enum class PixelStop : uint8_t {
  kNone = 0,        // no samples: the value comes from its neighbours
  kBudget = 1,      // all requested samples (--spp) were taken
  kThreshold = 2,   // --noise-threshold was met
  kMaximum = 3,     // --max-spp was reached
  kTimeLimit = 4,   // --time-limit ended the frame
  kUser = 5,        // a signal or a client stopped the frame
  kUnfinished = 6,  // not stopped yet: the frame is still rendering
  kTimeBudget = 7,  // all samples that --time-budget allowed were taken
};
std::string pixel_stop_name(PixelStop stop);  // for messages to the user

// A value of the `stop` channel is reason + kStopReasons * index. The index says which channel of
// the setting `judge` needed the pixel's last samples; it is 0 if only R G B is judged.
inline constexpr uint32_t kStopReasons = 8, kMaxJudged = 32;
inline uint8_t stop_value(PixelStop reason, uint32_t judged = 0) {
  return uint8_t(uint32_t(reason) + kStopReasons * judged);
}
inline PixelStop reason_of(uint8_t value) { return PixelStop(value % kStopReasons); }

}  // namespace emberline
