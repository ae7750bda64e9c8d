// Targets of animation channels: node properties and, with KHR_animation_pointer, most numbers of
// the document.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "io/gltf/document/document.h"
#include "io/json/schema_property.h"
#include "renderer/description/animation.h"

namespace emberline {

enum class NodeProperty : uint8_t {
  kTranslation,
  kRotation,
  kScale,
  kWeights,  // all morph target weights
  kWeight,   // one morph target weight
  kVisible,  // KHR_node_visibility
};

struct NodeTarget {
  size_t node = 0;
  NodeProperty property = NodeProperty::kTranslation;
  size_t weight = 0;  // the weight's index, for kWeight
};

struct GltfTarget {
  std::string pointer;             // JSON pointer, such as "/nodes/3/rotation"
  size_t width = 1;                // numbers per value
  std::optional<NodeTarget> node;  // absent: the target is one or more numbers of the document
  const schema::Property* property = nullptr;  // describes those numbers
  bool by_pointer = false;                     // whether the channel uses KHR_animation_pointer

  bool has(NodeProperty which) const { return node && node->property == which; }
  // Whether the values are an array of scalars and not a vector.
  bool is_array() const { return has(NodeProperty::kWeights); }
};

// Thrown if the target does not exist or if this loader does not know it. The channel then has no
// effect.
struct NoTarget : InputError {
  explicit NoTarget(const InputError& reason) : InputError(reason) {}
};

// These return the JSON pointers to an animation, to one of its channels, and to a channel's
// sampler.
std::string animation_pointer(size_t animation);
std::string channel_pointer(size_t animation, size_t channel);
std::string sampler_pointer(size_t animation, const nlohmann::json& channel);

// Throws InputError for an interpolation that glTF does not define.
Interpolation interpolation_of(const nlohmann::json& sampler, const std::string& place);

// Returns the target of a channel; `target` is its "target" object at the JSON pointer `pointer`.
// Throws NoTarget, and InputError for a target that must not be animated.
GltfTarget find_target(const GltfDocument& document, const nlohmann::json& target,
                       const std::string& pointer);

// Number of morph targets of the node's mesh, taken from its first primitive. All primitives have
// the same number.
size_t morph_target_count(const GltfDocument& document, size_t node);
// Returns the weights of all morph targets: the node's, or else the mesh's, or else zeros.
std::vector<double> morph_weights(const GltfDocument& document, size_t node);

}  // namespace emberline
