// What the channel of an animation changes: a node's property, or by KHR_animation_pointer nearly
// any number of the file.
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
  kWeight,   // of one
  kVisible,  // KHR_node_visibility
};

struct NodeTarget {
  size_t node = 0;
  NodeProperty property = NodeProperty::kTranslation;
  size_t weight = 0;  // of kWeight: which
};

struct GltfTarget {
  std::string pointer;                         // of what is changed: "/nodes/3/rotation"
  size_t width = 1;                            // numbers of a value
  std::optional<NodeTarget> node;              // absent: a number, or numbers, of the document
  const schema::Property* property = nullptr;  // of those
  bool by_pointer = false;                     // said by KHR_animation_pointer

  bool has(NodeProperty which) const { return node && node->property == which; }
  // The values are an array of scalars, not a vector.
  bool is_array() const { return has(NodeProperty::kWeights); }
};

// Nothing that is there and that this loader knows: the channel is without effect.
struct NoTarget : InputError {
  explicit NoTarget(const InputError& reason) : InputError(reason) {}
};

// JSON pointers to an animation, its channel, and the sampler that a channel has.
std::string animation_pointer(size_t animation);
std::string channel_pointer(size_t animation, size_t channel);
std::string sampler_pointer(size_t animation, const nlohmann::json& channel);

// Throws InputError for another than the three.
Interpolation interpolation_of(const nlohmann::json& sampler, const std::string& place);

// Of a channel's "target", which stands at the JSON pointer `pointer`. Throws NoTarget, and
// InputError for what must not be animated.
GltfTarget find_target(const GltfDocument& document, const nlohmann::json& target,
                       const std::string& pointer);

// Morph targets of the mesh that the node has, by its first primitive: all have as many.
size_t morph_target_count(const GltfDocument& document, size_t node);
// Their weights as the file has them: the node's, else the mesh's, else none.
std::vector<double> morph_weights(const GltfDocument& document, size_t node);

}  // namespace emberline
