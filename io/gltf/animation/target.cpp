#include "io/gltf/animation/target.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "io/gltf/document/schema.h"
#include "renderer/core/name_or_index.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

struct NodePropertyEntry {
  std::string_view path;  // in a channel's target, or the end of a pointer to a node
  NodeProperty property;
  size_t width;
};
constexpr NodePropertyEntry kNodeProperties[] = {
    {"translation", NodeProperty::kTranslation, 3},
    {"rotation", NodeProperty::kRotation, 4},
    {"scale", NodeProperty::kScale, 3},
    {"weights", NodeProperty::kWeights, 0},  // as many as the mesh has morph targets
    {"extensions/KHR_node_visibility/visible", NodeProperty::kVisible, 1}};

// Parses an index as JSON pointers write it, without leading zeros.
std::optional<size_t> pointer_index(std::string_view text, size_t end) {
  return text.size() > 1 && text.front() == '0' ? std::nullopt : parse_index(text, end);
}

const json* mesh_of(const GltfDocument& document, size_t node) {
  const json* mesh = find_member(document.array("nodes")[node], "mesh");
  return mesh ? &document.array("meshes")[mesh->get<size_t>()] : nullptr;
}

class TargetFinder {
 public:
  TargetFinder(const GltfDocument& document, const std::string& pointer)
      : document_(document), pointer_(pointer) {}

  GltfTarget find(const json& target) const;

 private:
  template <class... Values>
  [[noreturn]] void throw_no_target(const char* member, fmt::format_string<Values...> reason,
                                    Values&&... values) const {
    throw NoTarget(InputError(document_.place(pointer_ + member),
                              fmt::format(reason, std::forward<Values>(values)...)));
  }
  GltfTarget node_target(size_t node, std::string_view path, bool by_pointer) const;
  GltfTarget pointer_target(const std::string& text) const;
  GltfTarget number_target(const std::string& text) const;
  bool is_defined(const std::string& text) const;

  static constexpr const char* kPointer = "/extensions/KHR_animation_pointer/pointer";
  const GltfDocument& document_;
  const std::string& pointer_;
};

GltfTarget TargetFinder::find(const json& target) const {
  const std::string path = target.at("path").get<std::string>();
  if (path == "pointer") {
    const json* extension = find_extension(target, "KHR_animation_pointer");
    if (!extension) throw_no_target("", "the target has no pointer");
    return pointer_target(extension->at("pointer").get<std::string>());
  }
  const json* node = find_member(target, "node");
  if (!node) throw_no_target("", "the target does not name a node");
  return node_target(node->get<size_t>(), path, false);
}

GltfTarget TargetFinder::node_target(size_t node, std::string_view path, bool by_pointer) const {
  const char* member = by_pointer ? kPointer : "/path";
  const json& object = document_.array("nodes")[node];
  if (object.is_null()) throw_no_target(member, "node {} is broken", node);
  constexpr std::string_view kWeightPrefix = "weights/";
  const bool one_weight = by_pointer && path.starts_with(kWeightPrefix);
  const auto entry =
      std::ranges::find(kNodeProperties, one_weight ? "weights" : path, &NodePropertyEntry::path);
  const bool known = entry != std::end(kNodeProperties) &&
                     (by_pointer || entry->property != NodeProperty::kVisible);
  if (!known) throw_no_target(member, "unknown property \"{}\"", shortened(path));
  GltfTarget target;
  target.pointer = "/nodes/" + std::to_string(node) + "/" + std::string(path);
  target.width = entry->width;
  target.node = {node, entry->property, 0};
  target.by_pointer = by_pointer;
  // The specification forbids animations of a node that has a matrix. We reject only rotations and
  // scales, since a translation can simply replace that of the matrix.
  const bool turns = target.has(NodeProperty::kRotation) || target.has(NodeProperty::kScale);
  if (turns && object.contains("matrix")) {
    const InputError fault(document_.place(pointer_ + member),
                           "node {} has a matrix, so its {} cannot be animated", node, path);
    if (by_pointer) throw NoTarget(fault);
    throw fault;
  }
  if (target.has(NodeProperty::kVisible) && !find_extension(object, "KHR_node_visibility")) {
    throw_no_target(member, "node {} has no KHR_node_visibility", node);
  }
  if (!target.is_array()) return target;
  const size_t weights = morph_target_count(document_, node);
  if (weights == 0) {
    const InputError fault(document_.place(pointer_ + member),
                           "node {} has no mesh with morph targets", node);
    if (by_pointer) throw NoTarget(fault);
    throw fault;
  }
  target.width = weights;
  if (one_weight) {
    const auto which = pointer_index(path.substr(kWeightPrefix.size()), weights);
    if (!which)
      throw_no_target(member, "the mesh of node {} has only {} morph targets", node, weights);
    target.node = {node, NodeProperty::kWeight, *which};
    target.width = 1;
  }
  return target;
}

GltfTarget TargetFinder::pointer_target(const std::string& text) const {
  constexpr std::string_view kNodes = "/nodes/";
  if (!text.starts_with(kNodes)) return number_target(text);
  const std::string_view rest = std::string_view(text).substr(kNodes.size());
  const size_t slash = std::min(rest.find('/'), rest.size());
  const auto node = pointer_index(rest.substr(0, slash), document_.array("nodes").size());
  if (!node) throw_no_target(kPointer, "\"{}\" does not exist", shortened(text));
  return node_target(*node, rest.substr(std::min(slash + 1, rest.size())), true);
}

// Accepts numbers that this loader reads and that the glTF object model allows to be animated.
GltfTarget TargetFinder::number_target(const std::string& text) const {
  constexpr std::string_view kAnimatableRoots[] = {"/materials/", "/cameras/",
                                                   "/extensions/KHR_lights_punctual/lights/"};
  using schema::Kind;
  const schema::Property* property = nullptr;
  if (std::ranges::any_of(kAnimatableRoots, [&](auto root) { return text.starts_with(root); })) {
    property = find_property(text);
  }
  const bool numbers = property && property->kind == Kind::kNumbers;
  if (!numbers && !(property && property->kind == Kind::kNumber)) {
    throw_no_target(kPointer, "\"{}\" cannot be animated", shortened(text));
  }
  if (!is_defined(text)) throw_no_target(kPointer, "\"{}\" does not exist", shortened(text));
  GltfTarget target;
  target.pointer = text;
  target.width = numbers ? property->count : 1;
  target.property = property;
  target.by_pointer = true;
  return target;
}

// Whether the member exists, or can be added because its object exists and the member has a default
// value.
bool TargetFinder::is_defined(const std::string& text) const {
  constexpr std::string_view kWithoutDefault[] = {"/aspectRatio", "/zfar", "/range"};
  try {
    const json::json_pointer pointer(text);
    if (document_.json->contains(pointer)) return true;
    if (std::ranges::any_of(kWithoutDefault, [&](auto end) { return text.ends_with(end); })) {
      return false;
    }
    const json::json_pointer object = pointer.parent_pointer();
    return document_.json->contains(object) && document_.json->at(object).is_object();
  } catch (const json::exception&) {
    return false;  // for example, an index with leading zeros
  }
}

}  // namespace

std::string animation_pointer(size_t animation) {
  return "/animations/" + std::to_string(animation);
}

std::string channel_pointer(size_t animation, size_t channel) {
  return animation_pointer(animation) + "/channels/" + std::to_string(channel);
}

std::string sampler_pointer(size_t animation, const json& channel) {
  return animation_pointer(animation) + "/samplers/" + channel.at("sampler").dump();
}

Interpolation interpolation_of(const json& sampler, const std::string& place) {
  const std::string name = sampler.value("interpolation", "LINEAR");
  if (name == "LINEAR") return Interpolation::kLinear;
  if (name == "STEP") return Interpolation::kStep;
  if (name == "CUBICSPLINE") return Interpolation::kCubicSpline;
  throw InputError(place + "/interpolation",
                   "unknown interpolation \"{}\", expected LINEAR, STEP or CUBICSPLINE",
                   shortened(name));
}

GltfTarget find_target(const GltfDocument& document, const json& target,
                       const std::string& pointer) {
  return TargetFinder(document, pointer).find(target);
}

size_t morph_target_count(const GltfDocument& document, size_t node) {
  const json* mesh = mesh_of(document, node);
  if (!mesh || mesh->is_null() || mesh->at("primitives").empty()) return 0;
  const json* targets = find_member(mesh->at("primitives")[0], "targets");
  return targets ? targets->size() : 0;
}

std::vector<double> morph_weights(const GltfDocument& document, size_t node) {
  const json* weights = find_member(document.array("nodes")[node], "weights");
  const json* mesh = mesh_of(document, node);
  if (!weights && mesh) weights = find_member(*mesh, "weights");
  std::vector<double> values =
      weights ? weights->get<std::vector<double>>() : std::vector<double>();
  values.resize(morph_target_count(document, node), 0.0);
  return values;
}

}  // namespace emberline
