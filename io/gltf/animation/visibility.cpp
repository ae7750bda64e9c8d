#include "io/gltf/animation/visibility.h"

#include <nlohmann/json.hpp>

#include "io/gltf/animation/animated_values.h"

namespace emberline {

using nlohmann::json;

GltfVisibility::GltfVisibility(const GltfDocument& document, const GltfAnimation& animation)
    : document_(document),
      visible_times_(document.parents.size()),
      may_be_visible_(document.parents.size(), 1) {
  for (const int index : document.node_order) {
    const auto node = size_t(index);
    const json& object = document.array("nodes")[node];
    const json* own = object.is_null() ? nullptr : find_extension(object, "KHR_node_visibility");
    const auto track = animation.visibility.find(node);
    if (track != animation.visibility.end()) {
      visible_times_[node] = read(animation, track->second);
    } else if (own && !own->value("visible", true)) {
      visible_times_[node] = never_visible_;
      may_be_visible_[node] = 0;
    }
    const int parent = document.parents[node];
    if (parent < 0) continue;
    visible_times_[node] = intersect(visible_times_[size_t(parent)], visible_times_[node]);
    may_be_visible_[node] = may_be_visible_[node] && may_be_visible_[size_t(parent)];
  }
}

GltfVisibility::TimesPtr GltfVisibility::read(const GltfAnimation& animation,
                                              const KeyFrames& keys) {
  const auto [entry, is_new] = track_cache_.try_emplace({keys.times.get(), keys.values.get()});
  if (!is_new) return entry->second;
  const auto visible_at = [&](double time) {
    double value = 0.0;
    sample_keys(keys, time, {&value, 1});
    return value != 0.0;
  };
  const KeyFrames* const all[] = {&keys};
  const std::vector<double> times = shutter_key_times(animation, all);
  VisibilityTimes result{visible_at(times[0]), {}};
  bool before = result.visible_at_open;
  for (size_t i = 1; i + 1 < times.size(); ++i) {
    if (i % 65536 == 0) document_.progress->check();
    const bool now = visible_at(times[i]);
    if (now != before) result.toggle_times.push_back(animation.shutter_fraction(times[i]));
    before = now;
  }
  return entry->second = share_times(std::move(result));
}

GltfVisibility::TimesPtr GltfVisibility::intersect(const TimesPtr& a, const TimesPtr& b) {
  if (!a || a == b) return b;
  if (!b) return a;
  if (a == never_visible_ || b == never_visible_) return never_visible_;
  const auto [entry, is_new] = intersection_cache_.try_emplace({a.get(), b.get()});
  if (!is_new) return entry->second;
  document_.progress->check();
  VisibilityTimes result{a->visible_at_open && b->visible_at_open, {}};
  bool in_a = a->visible_at_open, in_b = b->visible_at_open, before = result.visible_at_open;
  for (size_t i = 0, j = 0; i < a->toggle_times.size() || j < b->toggle_times.size();) {
    const bool is_a = j == b->toggle_times.size() ||
                      (i < a->toggle_times.size() && a->toggle_times[i] <= b->toggle_times[j]);
    const float time = is_a ? a->toggle_times[i++] : b->toggle_times[j++];
    (is_a ? in_a : in_b) ^= true;
    const bool now = in_a && in_b;
    if (now != before) result.toggle_times.push_back(time);
    before = now;
  }
  return entry->second = share_times(std::move(result));
}

GltfVisibility::TimesPtr GltfVisibility::share_times(VisibilityTimes times) {
  if (times.toggle_times.empty()) return times.visible_at_open ? nullptr : never_visible_;
  document_.reserve(MemoryPart::kGeometry, bytes_of(times.toggle_times.capacity(), sizeof(float)));
  changes_ += times.toggle_times.size();
  // In a hierarchy, a few key frames can cause many changes.
  if (changes_ > max_curve_times(document_)) {
    throw InputError(
        document_.file,
        "while the shutter is open, its nodes change visibility too often for a file of this size");
  }
  return std::make_shared<const VisibilityTimes>(std::move(times));
}

}  // namespace emberline
