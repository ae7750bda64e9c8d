// A request to end the frame early, with its cause.
#pragma once

#include <atomic>
#include <stop_token>

#include "renderer/film/pixel_stop.h"

namespace emberline {

// Thread-safe; the first request counts.
class StopRequest {
 public:
  // Returns false if there was an earlier request.
  bool request(PixelStop cause) {
    PixelStop none = PixelStop::kNone;
    if (!cause_.compare_exchange_strong(none, cause)) return false;
    source_.request_stop();  // after the cause, so that a reader of the token finds it
    return true;
  }
  // kNone if there was no request.
  PixelStop cause() const { return cause_.load(); }
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::atomic<PixelStop> cause_{PixelStop::kNone};
  std::stop_source source_;
};

}  // namespace emberline
