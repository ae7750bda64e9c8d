// How often each display value occurs in the picture as shown.
#pragma once

#include <array>
#include <memory>

#include "renderer/session/shown_picture.h"

namespace emberline {

class Histogram {
 public:
  static constexpr int kBins = 128;

  // Counts anew for a newer picture, at most a few times a second: under a millisecond.
  void update(const std::shared_ptr<const ShownPicture>& picture, double now_s);

  // Height of a bar, in [0, 1]; channel 0 to 2. The largest bar between black and white fills the
  // height, so that a black ground does not flatten all else.
  float height(size_t channel, int bin) const;
  // Shares of the pixels: with every channel at 0, with some channel at 255.
  double black() const { return black_; }
  double clipped() const { return clipped_; }

 private:
  std::array<std::array<uint32_t, kBins>, 3> counts_ = {};
  uint32_t most_ = 1;
  double black_ = 0.0, clipped_ = 0.0, counted_s_ = -1e9;
  std::shared_ptr<const ShownPicture> counted_;
};

}  // namespace emberline
