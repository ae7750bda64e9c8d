// When nodes are visible while the shutter is open (KHR_node_visibility). The times are exact,
// because visibility switches and time steps would blur that.
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/time_curve.h"

namespace emberline {

// A node is visible if it and all its ancestors are.
class GltfVisibility {
 public:
  // Throws InputError for more changes than the file's size bears out or memory allows.
  GltfVisibility(const GltfDocument& document, const GltfAnimation& animation);

  // Whether a node is visible at some time; and when (null: always).
  bool shows(size_t node) const { return shown_[node] != never_; }
  const std::shared_ptr<const ShownTimes>& times(size_t node) const { return shown_[node]; }
  // Whether it may be visible at another time of the animation.
  bool may_show(size_t node) const { return may_show_[node]; }

 private:
  using Shown = std::shared_ptr<const ShownTimes>;
  Shown read(const GltfAnimation& animation, const KeyFrames& keys);
  Shown both(const Shown& a, const Shown& b);
  Shown keep(ShownTimes times);

  const GltfDocument& document_;
  const Shown never_ = std::make_shared<ShownTimes>(ShownTimes{false, {}});
  std::vector<Shown> shown_;  // per node
  std::vector<char> may_show_;
  // Caches, by a track's times and values, and by the two combined nodes.
  std::map<std::pair<const void*, const void*>, Shown> of_keys_, of_both_;
  uint64_t changes_ = 0;  // of all nodes
};

}  // namespace emberline
