// Notices pictures that are mostly white because the scene is lit in candela, lux or lumens.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "io/display/display.h"

namespace emberline {

class ExposureHint {
 public:
  // `transform` decides which radiance is white; views may compress highlights.
  ExposureHint(const DisplayTransform& transform, float exposure);

  // Counts the pixels of a tile, interleaved RGBA, without those that are fully transparent. Any
  // thread.
  void add(std::span<const float> rgba);
  // The exposure that makes the median a middle grey, in whole stops; nullopt unless most pixels
  // are brighter than white.
  std::optional<int> suggestion() const;

 private:
  // Stops above white of any float at any exposure; bin 0 has the pixels that are not brighter.
  static constexpr size_t kBins = 256;

  const float exposure_;
  float white_ = 0;  // 0: no radiance is shown as white
  std::array<std::atomic<uint64_t>, kBins> pixels_{};
};

}  // namespace emberline
