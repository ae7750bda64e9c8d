// A request to end the frame early, with its cause.
#pragma once

#include <atomic>
#include <stop_token>

#include "renderer/film/pixel_stop.h"

namespace emberline {

// Thread-safe; the first request counts.
class StopRequest {
 public:
  // Returns false if a stop has already been requested.
  bool request(PixelStop cause) {
    PixelStop none = PixelStop::kNone;
    if (!cause_.compare_exchange_strong(none, cause)) return false;
    source_.request_stop();  // comes last, so that readers of the token find the cause
    return true;
  }
  // Returns kNone if no stop has been requested.
  PixelStop cause() const { return cause_.load(); }
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::atomic<PixelStop> cause_{PixelStop::kNone};
  std::stop_source source_;
};

}  // namespace emberline
