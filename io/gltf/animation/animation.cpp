#include "io/gltf/animation/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <tuple>

#include "io/gltf/document/accessor.h"
#include "renderer/core/log.h"
#include "renderer/core/name_or_index.h"

namespace emberline {
namespace {

using nlohmann::json;

// ---- key frames

class AnimationReader {
 public:
  AnimationReader(const GltfDocument& document, GltfAnimation& animation)
      : document_(document), animation_(animation) {}

  void read(size_t index);
  void warn_about_repairs() const;

 private:
  using Numbers = KeyFrames::Numbers;
  // Cache key. Samplers that use an accessor in the same way share its values.
  using ValuesKey = std::tuple<int, bool, bool>;  // accessor, rotations, splines

  KeyFrames read_keys(const json& sampler, const GltfTarget& target, const std::string& place);
  Numbers read_times(int accessor, const std::string& place);
  Numbers read_values(int accessor, const KeyFrames& keys, size_t components,
                      const std::string& place);
  std::vector<float> read_numbers(int accessor, size_t components, const std::string& place);
  void check_rotations(const std::vector<float>& values, bool splines, const std::string& place);
  void add_track(const GltfTarget& target, KeyFrames keys);

  const GltfDocument& document_;
  GltfAnimation& animation_;
  std::map<int, Numbers> times_;  // by accessor
  std::map<ValuesKey, Numbers> values_;
  uint64_t non_unit_rotations_ = 0;
  std::string first_non_unit_place_;
};

void AnimationReader::read(size_t index) {
  document_.faults->require(animation_pointer(index));
  const json& animation = document_.array("animations")[index];
  const json& channels = animation.at("channels");
  for (size_t c = 0; c < channels.size(); ++c) {
    document_.progress->check();
    const std::string pointer = channel_pointer(index, c) + "/target";
    try {
      const GltfTarget target = find_target(document_, channels[c].at("target"), pointer);
      const json& sampler = animation.at("samplers")[channels[c].at("sampler").get<size_t>()];
      add_track(target,
                read_keys(sampler, target, document_.place(sampler_pointer(index, channels[c]))));
    } catch (const NoTarget& reason) {
      document_.faults->note_defaulted(pointer, reason);
    }
  }
}

void AnimationReader::add_track(const GltfTarget& target, KeyFrames keys) {
  // Reserves memory for the track, three poses of its node, and three copies of the pointer's text.
  animation_.memory.add(sizeof(NodeTrack) + sizeof(PointerTrack) + 3 * sizeof(NodePose) +
                            bytes_of(3 * keys.width, sizeof(double)) + 3 * target.pointer.size(),
                        document_.place(target.pointer));
  animation_.duration = std::max(animation_.duration, keys.last());
  if (!target.node) {
    animation_.pointers.push_back({target.pointer, target.property, std::move(keys)});
    return;
  }
  if (target.has(NodeProperty::kVisible)) {
    animation_.visibility[target.node->node] = std::move(keys);
    return;
  }
  if (target.has(NodeProperty::kWeights) || target.has(NodeProperty::kWeight)) {
    const size_t node = target.node->node;
    if (!animation_.weights.contains(node)) {
      animation_.weights.emplace(node, morph_weights(document_, node));
    }
  }
  animation_.nodes.push_back({*target.node, std::move(keys)});
}

KeyFrames AnimationReader::read_keys(const json& sampler, const GltfTarget& target,
                                     const std::string& place) {
  KeyFrames keys;
  keys.interpolation = interpolation_of(sampler, place);
  keys.rotations = target.has(NodeProperty::kRotation);
  keys.width = target.width;
  keys.times = read_times(sampler.at("input").get<int>(), place + "/input");
  keys.values = read_values(sampler.at("output").get<int>(), keys,
                            target.is_array() ? 1 : target.width, place + "/output");
  return keys;
}

std::vector<float> AnimationReader::read_numbers(int accessor, size_t components,
                                                 const std::string& place) {
  check_zero_count(document_, accessor, place);
  animation_.memory.add(bytes_of(document_.accessor(accessor).count, components * sizeof(float)),
                        place);
  std::vector<float> numbers = read_floats(document_, accessor, int(components), place);
  const auto broken = std::ranges::find_if_not(numbers, [](float x) { return std::isfinite(x); });
  if (broken != numbers.end()) {
    throw InputError(place, "element {} is not a finite number",
                     size_t(broken - numbers.begin()) / components);
  }
  return numbers;
}

KeyFrames::Numbers AnimationReader::read_times(int accessor, const std::string& place) {
  Numbers& entry = times_[accessor];
  if (entry) return entry;
  std::vector<float> times = read_numbers(accessor, 1, place);
  if (times.front() < 0.0f) {
    throw InputError(place, "the first key frame is at {} s, before the animation begins",
                     times.front());
  }
  const auto fall = std::ranges::adjacent_find(times, [](float a, float b) { return !(a < b); });
  if (fall != times.end()) {
    throw InputError(place, "key times must increase: key frame {} is at {} s, the next at {} s",
                     fall - times.begin(), *fall, *(fall + 1));
  }
  return entry = std::make_shared<const std::vector<float>>(std::move(times));
}

KeyFrames::Numbers AnimationReader::read_values(int accessor, const KeyFrames& keys,
                                                size_t components, const std::string& place) {
  const bool splines = keys.interpolation == Interpolation::kCubicSpline;
  Numbers& entry = values_[{accessor, keys.rotations, splines}];
  if (entry) return entry;
  std::vector<float> values = read_numbers(accessor, components, place);
  if (keys.rotations) check_rotations(values, splines, place);
  return entry = std::make_shared<const std::vector<float>>(std::move(values));
}

// Checks each key frame. Does not check the tangents of splines, which are not rotations.
void AnimationReader::check_rotations(const std::vector<float>& values, bool splines,
                                      const std::string& place) {
  // The tolerance exceeds the error of a unit quaternion that is stored as signed bytes.
  constexpr double kTolerance = 0.02;
  const size_t stride = splines ? 12 : 4;
  for (size_t at = splines ? 4 : 0; at < values.size(); at += stride) {
    const double length = std::hypot(std::hypot(double(values[at]), double(values[at + 1])),
                                     std::hypot(double(values[at + 2]), double(values[at + 3])));
    if (length == 0.0) {
      throw InputError(place, "the rotation of key frame {} is zero", at / stride);
    }
    if (std::abs(length - 1.0) <= kTolerance) continue;
    if (non_unit_rotations_++ == 0) first_non_unit_place_ = place;
  }
}

void AnimationReader::warn_about_repairs() const {
  if (non_unit_rotations_ == 0) return;
  log_warning(fmt::format(
      "{}: {} rotations, of which this is the first, do not have unit length; they are normalised",
      first_non_unit_place_, non_unit_rotations_));
}

// ---- selection

// If the name is not found, and the name of a broken animation is unknown, throws the fault of that
// animation, since it may be the wanted one.
size_t choose_animation(const GltfDocument& document, const std::string& wanted,
                        const std::vector<AnimationDescription>& list) {
  try {
    return find_name_or_index("animation", wanted, list);
  } catch (const UsageError&) {
    for (size_t i = 0; i < list.size(); ++i) {
      if (list[i].name.empty()) document.faults->require(animation_pointer(i));
    }
    throw;
  }
}

std::vector<size_t> choose_animations(const GltfDocument& document, const GltfOptions& options,
                                      const std::vector<AnimationDescription>& list) {
  const std::string& wanted = options.animation;
  if (wanted.empty() && !options.time) return {};
  document.faults->require("/animations");
  if (wanted.empty() && list.empty()) {
    log_info(document.file + ": the file has no animation, so the time has no effect");
    return {};
  }
  if (wanted.empty()) {
    if (list.size() > 1) {
      log_info(fmt::format("{}: the first animation is used; {}", document.file, list_names(list)));
    }
    return {0};
  }
  const bool all = wanted == "all" && !list.empty() &&
                   std::ranges::find(list, wanted, &AnimationDescription::name) == list.end();
  if (!all) return {choose_animation(document, wanted, list)};
  std::vector<size_t> indices(list.size());
  std::iota(indices.begin(), indices.end(), size_t(0));
  return indices;
}

// Compares times as float, which is the type of key times. In double, a frame at the last key could
// seem to be later than that key, because key times are rounded.
void log_if_outside(const GltfDocument& document, const GltfAnimation& animation) {
  const bool before = animation.time < 0.0;
  if (!before && float(animation.time) <= float(animation.duration)) return;
  log_info(
      fmt::format("{}: the time {:.6g} s is outside the animation, which lasts {:.6g} s; the pose "
                  "at its {} is used",
                  document.file, animation.time, animation.duration, before ? "beginning" : "end"));
}

// ---- at a time

void apply_track(const NodeTrack& track, double time, NodePose& pose) {
  const NodeTarget& target = track.target;
  if (target.property == NodeProperty::kWeights) return sample_keys(track.keys, time, pose.weights);
  Quaternion value{};  // properties other than weights have at most four numbers
  sample_keys(track.keys, time, std::span(value).first(track.keys.width));
  switch (target.property) {
    case NodeProperty::kTranslation:
      pose.translation = Vec3d(value[0], value[1], value[2]);
      return;
    case NodeProperty::kRotation:
      pose.rotation = value;
      return;
    case NodeProperty::kScale:
      pose.scale = Vec3d(value[0], value[1], value[2]);
      return;
    case NodeProperty::kWeight:
      pose.weights[target.weight] = value[0];
      return;
    case NodeProperty::kWeights:
    case NodeProperty::kVisible:  // see GltfVisibility
      return;
  }
}

}  // namespace

GltfAnimation read_animation(const GltfDocument& document, const GltfOptions& options,
                             const std::vector<AnimationDescription>& list) {
  GltfAnimation animation;
  animation.memory = MemoryReservation(document.progress->budget(), MemoryPart::kFile);
  const std::vector<size_t> chosen = choose_animations(document, options, list);
  if (chosen.empty()) return animation;
  animation.at_rest = false;
  AnimationReader reader(document, animation);
  for (const size_t index : chosen) reader.read(index);
  reader.warn_about_repairs();
  return animation;
}

void set_time(const GltfDocument& document, const GltfOptions& options, GltfAnimation& animation) {
  if (animation.at_rest) return;
  animation.time = options.time.value_or(0.0);
  const GltfOptions::Shutter shutter = options.shutter.value_or(GltfOptions::Shutter{});
  animation.open = animation.time + shutter.open;
  animation.close = animation.time + shutter.close;
  animation.next_frame.reset();
  if (options.next_frame && !(animation.open < animation.close)) {
    animation.next_frame = animation.open + *options.next_frame;
  }
  log_if_outside(document, animation);
}

std::vector<char> nodes_that_may_move(const GltfDocument& document,
                                      const GltfAnimation& animation) {
  std::vector<char> moves(document.array("nodes").size(), 0);
  for (const NodeTrack& track : animation.nodes) {
    const NodeProperty property = track.target.property;
    const bool morphs = property == NodeProperty::kWeights || property == NodeProperty::kWeight;
    if (!morphs) moves[track.target.node] = 1;
  }
  for (const auto& [node, keys] : animation.visibility) moves[node] = 1;
  for (const int node : document.node_order) {
    const int parent = document.parents[size_t(node)];
    if (parent >= 0 && moves[size_t(parent)]) moves[size_t(node)] = 1;
  }
  return moves;
}

GltfPose pose_at(const GltfAnimation& animation, double time) {
  GltfPose pose;
  for (const auto& [node, weights] : animation.weights) pose[node].weights = weights;
  for (const NodeTrack& track : animation.nodes) apply_track(track, time, pose[track.target.node]);
  return pose;
}

// Compares times as float, which is the type of key times. In double, a key at shutter opening or
// closing could be listed twice, because key times are rounded.
std::vector<double> shutter_key_times(const GltfAnimation& animation,
                                      std::span<const KeyFrames* const> keys) {
  if (!(animation.open < animation.close)) return {animation.open};
  std::vector<double> all = {animation.open};
  for (const KeyFrames* frames : keys) {
    const std::vector<float>& times = *frames->times;
    const auto first = std::upper_bound(times.begin(), times.end(), float(animation.open));
    all.insert(all.end(), first, std::lower_bound(first, times.end(), float(animation.close)));
  }
  if (keys.size() > 1) std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  all.push_back(animation.close);
  return all;
}

void sample_value(const PointerTrack& track, double time, std::span<double> value) {
  sample_keys(track.keys, time, value);
  constexpr double kRounding = 1e-6;
  for (double& number : value) {
    const double sampled = number;
    number = std::clamp(number, track.property->minimum, track.property->maximum);
    if (std::abs(sampled - number) > kRounding * std::max(1.0, std::abs(number))) {
      track.was_clamped = true;
    }
  }
}

void write_values_at(const GltfAnimation& animation, double time, json& document) {
  for (const PointerTrack& track : animation.pointers) {
    track.was_clamped = false;
    std::vector<double> values(track.keys.width);
    sample_value(track, time, values);
    json& target = document[json::json_pointer(track.pointer)];
    if (track.property->kind == schema::Kind::kNumber) {
      target = values.front();
    } else {
      target = values;
    }
  }
}

void report_clamped_values(const GltfDocument& document, const GltfAnimation& animation) {
  constexpr size_t kMaxNamed = 8;  // a file may clamp any number of values
  std::string names;
  size_t count = 0;
  for (const PointerTrack& track : animation.pointers) {
    if (!track.was_clamped || ++count > kMaxNamed) continue;
    names += (names.empty() ? "" : ", ") + track.pointer;
  }
  if (count > kMaxNamed) names += fmt::format(", and {} more", count - kMaxNamed);
  if (count > 0) {
    log_warning(document.file + ": animated values outside the specification's range are " +
                "clamped: " + names);
  }
}

}  // namespace emberline
