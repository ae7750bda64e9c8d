// When nodes are there while the shutter is open (KHR_node_visibility), exactly: visibility is
// switched, and time steps would smear that.
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/time_curve.h"

namespace emberline {

// A node is there where it says so itself and all nodes above it do.
class GltfVisibility {
 public:
  // Throws InputError for more switching than the file's size bears out, or memory allows.
  GltfVisibility(const GltfDocument& document, const GltfAnimation& animation);

  // Whether a node is there at some time; and when, null: always.
  bool shows(size_t node) const { return shown_[node] != never_; }
  const std::shared_ptr<const ShownTimes>& times(size_t node) const { return shown_[node]; }
  // Whether it may be there at another time of the animation.
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
  // What has been made of key frames, by their times and values; and of two nodes together.
  std::map<std::pair<const void*, const void*>, Shown> of_keys_, of_both_;
  uint64_t changes_ = 0;  // of all
};

}  // namespace emberline
