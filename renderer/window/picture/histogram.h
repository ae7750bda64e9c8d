// Histogram of the picture's display values.
#pragma once

#include <array>
#include <memory>

#include "renderer/session/session_picture.h"

namespace emberline {

class Histogram {
 public:
  static constexpr int kBins = 128;

  // Counts the pixels of `picture` if it is a new one, but at most five times a second. Takes less
  // than a millisecond.
  void update(const std::shared_ptr<const SessionPicture>& picture, double now_s);

  // Returns the height of a bar, in [0, 1], for channels 0 to 2. It is relative to the highest bar
  // other than the first and last, so that a black background does not flatten the other bars.
  float height(size_t channel, int bin) const;
  // Return the fraction of pixels with all channels at 0, and the fraction with any channel at 255.
  double black() const { return black_; }
  double clipped() const { return clipped_; }

 private:
  std::array<std::array<uint32_t, kBins>, 3> counts_ = {};
  uint32_t max_count_ = 1;
  double black_ = 0.0, clipped_ = 0.0, updated_s_ = -1e9;
  std::shared_ptr<const SessionPicture> picture_;
};

}  // namespace emberline
