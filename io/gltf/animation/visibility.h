// Finds when nodes are visible while the shutter is open (KHR_node_visibility). The times are
// exact, because visibility changes abruptly, and time steps would blur the change.
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/time_curve.h"

namespace emberline {

// A node is visible if the node and all its ancestors are visible.
class GltfVisibility {
 public:
  // Throws InputError for more changes than memory or the file's size allows.
  GltfVisibility(const GltfDocument& document, const GltfAnimation& animation);

  // Whether the node is visible at any time while the shutter is open. times() returns these times,
  // or null if the node is always visible.
  bool is_ever_visible(size_t node) const { return visible_times_[node] != never_visible_; }
  const std::shared_ptr<const VisibilityTimes>& times(size_t node) const {
    return visible_times_[node];
  }
  // False if the file hides the node at every time of the animation.
  bool may_be_visible(size_t node) const { return may_be_visible_[node]; }

 private:
  using TimesPtr = std::shared_ptr<const VisibilityTimes>;
  TimesPtr read(const GltfAnimation& animation, const KeyFrames& keys);
  TimesPtr intersect(const TimesPtr& a, const TimesPtr& b);
  TimesPtr share_times(VisibilityTimes times);

  const GltfDocument& document_;
  const TimesPtr never_visible_ = std::make_shared<VisibilityTimes>(VisibilityTimes{false, {}});
  std::vector<TimesPtr> visible_times_;  // per node
  std::vector<char> may_be_visible_;
  // Caches. The keys point to a track's times and values, or to the operands of intersect().
  std::map<std::pair<const void*, const void*>, TimesPtr> track_cache_, intersection_cache_;
  uint64_t changes_ = 0;  // total number for all nodes
};

}  // namespace emberline
