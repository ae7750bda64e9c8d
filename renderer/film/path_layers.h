// The light-path layers of a film.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/film/channels.h"

namespace emberline {

// How the first surface sent light to the camera. The light of a path goes to one layer, or is
// split between kReflection and either kDirect or kIndirect according to the diffuse share of the
// reflection. The layers add up to the radiance.
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
  // The layers in the order of the film's layer sums.
  const std::vector<PathLayer>& list() const { return list_; }
  bool empty() const { return list_.empty(); }
  int size() const { return int(list_.size()); }
  // The layer's index in the list; kPathLayers if the film lacks the layer.
  uint32_t index_of(PathLayer layer) const { return indices_[size_t(layer)]; }

 private:
  std::vector<PathLayer> list_;
  std::array<uint32_t, kPathLayers> indices_;
};

}  // namespace emberline
