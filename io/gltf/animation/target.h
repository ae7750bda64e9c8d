// Targets of animation channels: node properties and, by KHR_animation_pointer, most numbers.
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
  kWeights,  // of all morph targets
  kWeight,   // of one morph target
  kVisible,  // KHR_node_visibility
};

struct NodeTarget {
  size_t node = 0;
  NodeProperty property = NodeProperty::kTranslation;
  size_t weight = 0;  // index, for kWeight
};

struct GltfTarget {
  std::string pointer;             // of the target: "/nodes/3/rotation"
  size_t width = 1;                // numbers per value
  std::optional<NodeTarget> node;  // absent: the target is one or more numbers of the document
  const schema::Property* property = nullptr;  // of those numbers
  bool by_pointer = false;                     // uses KHR_animation_pointer

  bool has(NodeProperty which) const { return node && node->property == which; }
  // The values are an array of scalars, not a vector.
  bool is_array() const { return has(NodeProperty::kWeights); }
};

// The target does not exist or is unknown to this loader: the channel has no effect.
struct NoTarget : InputError {
  explicit NoTarget(const InputError& reason) : InputError(reason) {}
};

// JSON pointers to an animation, to its channel, and to a channel's sampler.
std::string animation_pointer(size_t animation);
std::string channel_pointer(size_t animation, size_t channel);
std::string sampler_pointer(size_t animation, const nlohmann::json& channel);

// Throws InputError for an interpolation that glTF does not define.
Interpolation interpolation_of(const nlohmann::json& sampler, const std::string& place);

// The target of a channel; `target` is its "target" object at the JSON pointer `pointer`. Throws
// NoTarget, and InputError for a target that must not be animated.
GltfTarget find_target(const GltfDocument& document, const nlohmann::json& target,
                       const std::string& pointer);

// Number of morph targets of the node's mesh, by its first primitive; all have the same number.
size_t morph_target_count(const GltfDocument& document, size_t node);
// The file's own weights: the node's, or else the mesh's, or else none.
std::vector<double> morph_weights(const GltfDocument& document, size_t node);

}  // namespace emberline
