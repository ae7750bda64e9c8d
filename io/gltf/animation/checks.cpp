// Validates the JSON of animations and describes them.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/accessor.h"

namespace emberline {
namespace {

using nlohmann::json;

// Checks the output's type against the tables in section 3.11 of the glTF specification and in
// KHR_animation_pointer.
void check_output_type(const GltfAccessor& output, const GltfTarget& target,
                       const std::string& place) {
  const int type = output.component_type;
  if (target.has(NodeProperty::kVisible)) {
    if (type == 5121 && !output.normalized) return;
    throw InputError(place, "expected unsigned bytes (true or false)");
  }
  if (type == 5126 || target.by_pointer) return;
  const bool integers = target.has(NodeProperty::kRotation) || target.is_array();
  if (integers && output.normalized && type <= 5123) return;
  throw InputError(place, "expected floats{}",
                   integers ? ", or normalized integers of 8 or 16 bits" : "");
}

void check_sampler(const GltfDocument& document, const json& sampler, const GltfTarget& target,
                   const std::string& place) {
  const Interpolation interpolation = interpolation_of(sampler, place);
  const GltfAccessor& input = document.accessor(sampler.at("input").get<int>());
  if (input.components != 1 || input.component_type != 5126) {
    throw InputError(place + "/input", "expected an accessor of SCALAR floats, times in seconds");
  }
  const GltfAccessor& output = document.accessor(sampler.at("output").get<int>());
  const size_t components = target.is_array() ? 1 : target.width;
  if (size_t(output.components) != components) {
    throw InputError(place + "/output", "the accessor has {} components, expected {}",
                     output.components, components);
  }
  check_output_type(output, target, place + "/output");
  const uint64_t per_key = interpolation == Interpolation::kCubicSpline ? 3 : 1;
  const uint64_t expected = bytes_of(input.count, per_key * (target.width / components));
  if (output.count != expected) {
    throw InputError(place + "/output", "found {} values for {} key frames, expected {}",
                     output.count, input.count, expected);
  }
  if (target.has(NodeProperty::kVisible) && interpolation != Interpolation::kStep) {
    throw InputError(place + "/interpolation",
                     "expected STEP, the only interpolation for a boolean property");
  }
}

// Rejects a target that equals, contains or is part of one of the pointers in `earlier_targets`.
void check_new_target(std::set<std::string>& earlier_targets, const std::string& target,
                      const std::string& place) {
  const std::string parts = target + "/";
  const auto part = earlier_targets.lower_bound(parts);
  const bool is_there = earlier_targets.contains(target) ||
                        earlier_targets.contains(target.substr(0, target.rfind('/'))) ||
                        (part != earlier_targets.end() && part->starts_with(parts));
  if (is_there) throw InputError(place, "{} is animated twice", target);
  earlier_targets.insert(target);
}

void check_animation(const GltfDocument& document, const json& animation, size_t index) {
  const json& channels = animation.at("channels");
  const json& samplers = animation.at("samplers");
  std::set<std::string> targets;
  for (size_t c = 0; c < channels.size(); ++c) {
    const std::string pointer = channel_pointer(index, c);
    const size_t sampler = channels[c].at("sampler").get<size_t>();
    if (sampler >= samplers.size()) {
      throw InputError(document.place(pointer + "/sampler"),
                       "index {} is out of range: the animation has {} samplers", sampler,
                       samplers.size());
    }
    try {
      const GltfTarget target =
          find_target(document, channels[c].at("target"), pointer + "/target");
      check_new_target(targets, target.pointer, document.place(pointer + "/target"));
      check_sampler(document, samplers[sampler], target,
                    document.place(sampler_pointer(index, channels[c])));
    } catch (const NoTarget&) {
      // A target that does not exist is reported when the animation is read.
    }
  }
}

// Finds the duration of animations. Reads only the last key time of each sampler.
class DurationReader {
 public:
  explicit DurationReader(const GltfDocument& document)
      : document_(document), max_sparse_elements_((uint64_t(1) << 22) + document.total_bytes) {}

  double last_time(int accessor, const std::string& place) {
    const auto known = last_.find(accessor);
    if (known != last_.end()) return known->second;
    document_.progress->check();
    const GltfAccessor& times = document_.accessor(accessor);
    check_zero_count(document_, accessor, place);
    // Finding the last element means searching all sparse indices. Therefore their number is
    // limited.
    sparse_elements_ += times.sparse.count;
    if (times.count > UINT32_MAX || sparse_elements_ > max_sparse_elements_) {
      throw InputError(place, "too many key frames for a file of this size");
    }
    const std::vector<uint32_t> element = {uint32_t(times.count - 1)};
    const double last = read_floats(document_, accessor, 1, place, &element).front();
    return last_[accessor] = std::isfinite(last) ? last : 0.0;
  }

 private:
  const GltfDocument& document_;
  const uint64_t max_sparse_elements_;
  uint64_t sparse_elements_ = 0;
  std::map<int, double> last_;
};

void describe(const GltfDocument& document, size_t index, DurationReader& durations,
              AnimationDescription& description) {
  document.faults->require(animation_pointer(index));
  const json& animation = document.array("animations")[index];
  description.name = animation.value("name", "");
  std::set<size_t> moved, morphed;
  for (size_t c = 0; c < animation.at("channels").size(); ++c) {
    const json& channel = animation.at("channels")[c];
    try {
      const GltfTarget target =
          find_target(document, channel.at("target"), channel_pointer(index, c) + "/target");
      const bool weights = target.is_array() || target.has(NodeProperty::kWeight);
      if (weights) {
        morphed.insert(target.node->node);
      } else if (target.node && !target.has(NodeProperty::kVisible)) {
        moved.insert(target.node->node);
      } else {
        ++description.pointers;
      }
      const json& sampler = animation.at("samplers")[channel.at("sampler").get<size_t>()];
      description.duration =
          std::max(description.duration,
                   durations.last_time(sampler.at("input").get<int>(),
                                       document.place(sampler_pointer(index, channel) + "/input")));
    } catch (const NoTarget&) {
      ++description.without_effect;
    }
  }
  description.nodes = moved.size();
  description.morphs = morphed.size();
}

}  // namespace

void check_gltf_animations(GltfDocument& document) {
  document.check_each("/animations", [&](const json& animation, const std::string&, size_t i) {
    check_animation(document, animation, i);
  });
}

std::vector<AnimationDescription> describe_animations(const GltfDocument& document) {
  const size_t count = document.array("animations").size();
  document.reserve(MemoryPart::kFile, bytes_of(count, sizeof(AnimationDescription)));
  std::vector<AnimationDescription> list(count);
  DurationReader durations(document);
  for (size_t i = 0; i < list.size(); ++i) {
    try {
      describe(document, i, durations, list[i]);
    } catch (const InputError& error) {
      document.faults->note_broken(animation_pointer(i), error);
      list[i].fault = error.what();
    }
    document.reserve(MemoryPart::kFile, list[i].name.capacity() + list[i].fault.capacity());
  }
  return list;
}

}  // namespace emberline
