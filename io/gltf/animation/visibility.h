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
  bool is_ever_visible(size_t node) const { return visible_times_[node] != never_visible_; }
  const std::shared_ptr<const VisibilityTimes>& times(size_t node) const {
    return visible_times_[node];
  }
  // Whether it may be visible at another time of the animation.
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
  // Caches, by a track's times and values, and by the two combined nodes.
  std::map<std::pair<const void*, const void*>, TimesPtr> track_cache_, intersection_cache_;
  uint64_t changes_ = 0;  // of all nodes
};

}  // namespace emberline
