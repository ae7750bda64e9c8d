#include "renderer/film/film.h"

namespace emberline {

Aov aov_of(PathLayer layer) {
  static_assert(size_t(Aov::kEnvironment) - size_t(Aov::kDirect) ==
                size_t(PathLayer::kEnvironment));
  return static_cast<Aov>(size_t(Aov::kDirect) + size_t(layer));
}

PathLayers::PathLayers(const AovSet& aovs) {
  indices_.fill(kPathLayers);
  for (size_t i = 0; i < kPathLayers; ++i) {
    const auto layer = static_cast<PathLayer>(i);
    if (!aovs.contains(aov_of(layer))) continue;
    indices_[i] = uint32_t(list_.size());
    list_.push_back(layer);
  }
}

}  // namespace emberline
