// Detects pictures that are mostly white, for example because the scene's lights are in candela,
// lux or lumens.
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
  // Uses `transform` to find the radiance that is displayed as white, because a view may compress
  // highlights.
  ExposureHint(const DisplayTransform& transform, float exposure);

  // Counts the pixels of a tile (interleaved RGBA), except those that are fully transparent.
  // Thread-safe.
  void add(std::span<const float> rgba);
  // Returns the exposure, in whole stops, that makes the median pixel middle grey. Returns nullopt
  // unless most pixels are brighter than white.
  std::optional<int> suggestion() const;

 private:
  // One bin per stop above white, enough for any float at any exposure. Bin 0 counts the pixels
  // that are not brighter than white.
  static constexpr size_t kBins = 256;

  const float exposure_;
  float white_ = 0;  // 0: no radiance is shown as white
  std::array<std::atomic<uint64_t>, kBins> pixels_{};
};

}  // namespace emberline
