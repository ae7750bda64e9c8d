// The layers by light path of a film.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/film/channels.h"

namespace emberline {

// What the first surface did with the light that came to the camera; each path is of one, or of
// kDirect and kReflection, or kIndirect and kReflection, by what share of it the surface reflects
// diffusely. All of them add up to the radiance.
enum class PathLayer : uint8_t {
  kDirect,
  kIndirect,
  kEmission,
  kTransmission,
  kReflection,
  kEnvironment,
};
inline constexpr size_t kPathLayers = 6;
Aov aov_of(PathLayer layer);

// The layers that a film has.
class PathLayers {
 public:
  explicit PathLayers(const AovSet& aovs);
  // In the order of the film's.
  const std::vector<PathLayer>& list() const { return list_; }
  bool empty() const { return list_.empty(); }
  int size() const { return int(list_.size()); }
  // Its place in the list; of one that is not wanted a place beyond.
  uint32_t place_of(PathLayer layer) const { return places_[size_t(layer)]; }

 private:
  std::vector<PathLayer> list_;
  std::array<uint32_t, kPathLayers> places_;
};

}  // namespace emberline
