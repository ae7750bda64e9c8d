#include "io/gltf/animation/visibility.h"

#include <nlohmann/json.hpp>

#include "io/gltf/animation/changes.h"

namespace emberline {

using nlohmann::json;

GltfVisibility::GltfVisibility(const GltfDocument& document, const GltfAnimation& animation)
    : document_(document), shown_(document.parents.size()), may_show_(document.parents.size(), 1) {
  for (const int index : document.node_order) {
    const auto node = size_t(index);
    const json& object = document.array("nodes")[node];
    const json* own = object.is_null() ? nullptr : find_extension(object, "KHR_node_visibility");
    const auto track = animation.visibility.find(node);
    if (track != animation.visibility.end()) {
      shown_[node] = read(animation, track->second);
    } else if (own && !own->value("visible", true)) {
      shown_[node] = never_;
      may_show_[node] = 0;
    }
    const int parent = document.parents[node];
    if (parent < 0) continue;
    shown_[node] = both(shown_[size_t(parent)], shown_[node]);
    may_show_[node] = may_show_[node] && may_show_[size_t(parent)];
  }
}

GltfVisibility::Shown GltfVisibility::read(const GltfAnimation& animation, const KeyFrames& keys) {
  const auto [entry, is_new] = of_keys_.try_emplace({keys.times.get(), keys.values.get()});
  if (!is_new) return entry->second;
  const auto shown_at = [&](double time) {
    double value = 0.0;
    sample_keys(keys, time, {&value, 1});
    return value != 0.0;
  };
  const KeyFrames* const all[] = {&keys};
  const std::vector<double> times = times_within(animation, all);
  ShownTimes result{shown_at(times[0]), {}};
  bool before = result.at_opening;
  for (size_t i = 1; i + 1 < times.size(); ++i) {
    if (i % 65536 == 0) document_.progress->check();
    const bool now = shown_at(times[i]);
    if (now != before) result.changes.push_back(animation.share_of_shutter(times[i]));
    before = now;
  }
  return entry->second = keep(std::move(result));
}

GltfVisibility::Shown GltfVisibility::both(const Shown& a, const Shown& b) {
  if (!a || a == b) return b;
  if (!b) return a;
  if (a == never_ || b == never_) return never_;
  const auto [entry, is_new] = of_both_.try_emplace({a.get(), b.get()});
  if (!is_new) return entry->second;
  document_.progress->check();
  ShownTimes result{a->at_opening && b->at_opening, {}};
  bool in_a = a->at_opening, in_b = b->at_opening, before = result.at_opening;
  for (size_t i = 0, j = 0; i < a->changes.size() || j < b->changes.size();) {
    const bool is_a =
        j == b->changes.size() || (i < a->changes.size() && a->changes[i] <= b->changes[j]);
    const float time = is_a ? a->changes[i++] : b->changes[j++];
    (is_a ? in_a : in_b) ^= true;
    const bool now = in_a && in_b;
    if (now != before) result.changes.push_back(time);
    before = now;
  }
  return entry->second = keep(std::move(result));
}

GltfVisibility::Shown GltfVisibility::keep(ShownTimes times) {
  if (times.changes.empty()) return times.at_opening ? nullptr : never_;
  document_.reserve(MemoryPart::kGeometry, bytes_of(times.changes.capacity(), sizeof(float)));
  changes_ += times.changes.size();
  // A hierarchy multiplies the changes of a few key frames.
  if (changes_ > most_times(document_)) {
    throw InputError(
        document_.file,
        "its nodes change visibility too often while the shutter is open for a file of this size");
  }
  return std::make_shared<const ShownTimes>(std::move(times));
}

}  // namespace emberline
