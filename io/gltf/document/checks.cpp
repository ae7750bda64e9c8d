// Checks of a GltfDocument that span several objects: accessors and their buffer views, the node
// graph, skins.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "io/gltf/document/document.h"
#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

int component_count(const std::string& type) {
  static constexpr std::pair<const char*, int> kTypes[] = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  for (const auto& [name, count] : kTypes) {
    if (type == name) return count;
  }
  return 0;
}

int checked_component_size(const json& object, const std::string& place) {
  constexpr int kSizes[] = {1, 1, 2, 2, 0, 4, 4};  // 5120 BYTE .. 5126 FLOAT
  const int64_t type = object.at("componentType").get<int64_t>();
  const int size = type >= 5120 && type <= 5126 ? kSizes[type - 5120] : 0;
  if (size == 0) {
    throw InputError(place + "/componentType", "unknown component type {}", type);
  }
  return size;
}

// Throws unless `count` elements of `size` bytes, `stride` apart, lie within the view. All values
// are at most 2^53, and the stride is below 2^16. The view has bytes of a file or of memory, so its
// size is below 2^47. Comparing `count` with it first keeps the product below 2^63.
void check_range(const GltfView& view, uint64_t offset, uint64_t count, uint64_t stride,
                 uint64_t size, const std::string& place) {
  const bool exceeds_view = count > view.size;
  if (count == 0) return;
  if (exceeds_view || offset + (count - 1) * stride + size > view.size) {
    throw InputError(
        place, "{} elements of {} bytes from offset {} do not fit into the buffer view of {} bytes",
        count, size, offset, view.size);
  }
}

GltfAccessor::Sparse check_sparse(const GltfDocument& document, const json& object,
                                  const GltfAccessor& accessor, const std::string& place) {
  const json& indices = object.at("indices");
  const json& values = object.at("values");
  GltfAccessor::Sparse sparse;
  sparse.count = object.at("count").get<uint64_t>();
  sparse.index_view = indices.at("bufferView").get<int>();
  sparse.index_offset = indices.value("byteOffset", uint64_t(0));
  sparse.value_view = values.at("bufferView").get<int>();
  sparse.value_offset = values.value("byteOffset", uint64_t(0));
  const uint64_t index_size = uint64_t(checked_component_size(indices, place + "/indices"));
  sparse.index_type = indices.at("componentType").get<int>();
  if (sparse.index_type != 5121 && sparse.index_type != 5123 && sparse.index_type != 5125) {
    throw InputError(place + "/indices/componentType", "sparse indices must be unsigned integers");
  }
  if (sparse.count > accessor.count) {
    throw InputError(place + "/count", "there are more sparse elements than accessor elements");
  }
  const uint64_t element_size = uint64_t(accessor.component_size) * uint64_t(accessor.components);
  check_range(document.view(sparse.index_view), sparse.index_offset, sparse.count, index_size,
              index_size, place + "/indices");
  check_range(document.view(sparse.value_view), sparse.value_offset, sparse.count, element_size,
              element_size, place + "/values");
  return sparse;
}

GltfAccessor check_accessor(const GltfDocument& document, const json& object,
                            const std::string& place) {
  GltfAccessor accessor;
  accessor.component_size = checked_component_size(object, place);
  accessor.component_type = object.at("componentType").get<int>();
  const std::string type = object.at("type").get<std::string>();
  accessor.components = component_count(type);
  if (accessor.components == 0) {
    throw InputError(place + "/type", "unknown accessor type \"{}\"", shortened(type));
  }
  accessor.count = object.at("count").get<uint64_t>();
  accessor.normalized = object.value("normalized", false);
  accessor.offset = object.value("byteOffset", uint64_t(0));
  const uint64_t element_size = uint64_t(accessor.component_size * accessor.components);
  accessor.stride = element_size;
  if (const json* view = find_member(object, "bufferView")) {
    accessor.view = view->get<int>();
    const GltfView& bytes = document.view(accessor.view);
    const json& view_object = document.json->at("bufferViews")[size_t(accessor.view)];
    accessor.stride = view_object.value("byteStride", element_size);
    if (accessor.stride < element_size) {
      throw InputError(place,
                       "the byteStride of its buffer view ({}) is less than an element ({} bytes)",
                       accessor.stride, element_size);
    }
    check_range(bytes, accessor.offset, accessor.count, accessor.stride, element_size, place);
  }
  if (const json* sparse = find_member(object, "sparse")) {
    accessor.sparse = check_sparse(document, *sparse, accessor, place + "/sparse");
  }
  return accessor;
}

// Fills GltfDocument::parents and node_order. A node has at most one parent.
class NodeGraph {
 public:
  explicit NodeGraph(GltfDocument& document)
      : document_(document),
        nodes_(document.array("nodes")),
        in_scene_(nodes_.size(), 0),
        reached_(nodes_.size(), 0) {}

  void check() {
    find_scene();
    // The children of the scene's nodes are linked first, so that these links take precedence.
    document_.parents.assign(nodes_.size(), -1);
    for (size_t i = 0; i < nodes_.size(); ++i) {
      for (size_t k = 0; in_scene_[i] && k < child_count(i); ++k) link(i, k);
    }
    for (size_t i = 0; i < nodes_.size(); ++i) {
      for (size_t k = 0; !in_scene_[i] && k < child_count(i); ++k) link_outside(i, k);
    }
    order();
    find_cycles();
  }

 private:
  static std::string pointer(size_t node) { return "/nodes/" + std::to_string(node); }
  size_t child_count(size_t node) const {
    const json* children = find_member(nodes_[node], "children");
    return children ? children->size() : 0;
  }
  size_t child(size_t node, size_t k) const { return nodes_[node].at("children")[k].get<size_t>(); }
  void find_scene();
  void link(size_t node, size_t k);
  void link_outside(size_t node, size_t k);
  void order();
  void find_cycles() const;

  GltfDocument& document_;
  const json& nodes_;
  std::vector<char> in_scene_;
  std::vector<char> reached_;  // whether a path from a root leads to the node
};

// Marks the nodes of the chosen scene, or all nodes of a file without scenes.
void NodeGraph::find_scene() {
  const json& scenes = document_.array("scenes");
  if (scenes.empty()) return in_scene_.assign(nodes_.size(), 1);
  const size_t chosen = document_.json->value("scene", size_t(0));
  document_.faults->require("/scenes/" + std::to_string(chosen));
  std::vector<size_t> found;
  const auto add = [&](size_t node) {
    if (!in_scene_[node]) found.push_back(node);
    in_scene_[node] = 1;
  };
  const json* roots = find_member(scenes[chosen], "nodes");
  for (size_t k = 0; roots && k < roots->size(); ++k) add((*roots)[k].get<size_t>());
  for (size_t next = 0; next < found.size(); ++next) {
    for (size_t k = 0; k < child_count(found[next]); ++k) add(child(found[next], k));
  }
}

void NodeGraph::link(size_t node, size_t k) {
  const size_t linked = child(node, k);
  int& parent = document_.parents[linked];
  if (linked != node && parent < 0) {
    parent = int(node);
    return;
  }
  const std::string place = document_.place(pointer(node) + "/children/" + std::to_string(k));
  if (linked == node) throw InputError(place, "node {} is its own child", node);
  if (parent == int(node)) throw InputError(place, "node {} is listed twice", linked);
  throw InputError(place, "node {} already has another parent, node {}", linked, parent);
}

// A node with a bad link is broken. If the link would give a node outside the scene a second
// parent, that node is broken, too.
void NodeGraph::link_outside(size_t node, size_t k) {
  try {
    link(node, k);
  } catch (const InputError& error) {
    document_.faults->note_broken(pointer(node), error);
    const size_t linked = child(node, k);
    const bool has_two_parents = linked != node && document_.parents[linked] != int(node);
    if (has_two_parents && !in_scene_[linked]) {
      document_.faults->note_broken(pointer(linked), GltfFaults::KnownFault(error));
    }
  }
}

// Lists the nodes breadth-first from the roots.
void NodeGraph::order() {
  std::vector<int>& order = document_.node_order;
  order.reserve(nodes_.size());
  const auto add = [&](size_t node) {
    if (!reached_[node]) order.push_back(int(node));
    reached_[node] = 1;
  };
  for (size_t i = 0; i < nodes_.size(); ++i) {
    if (document_.parents[i] < 0) add(i);
  }
  for (size_t next = 0; next < order.size(); ++next) {
    const size_t node = size_t(order[next]);
    for (size_t k = 0; k < child_count(node); ++k) {
      const size_t linked = child(node, k);
      if (document_.parents[linked] == int(node)) add(linked);
    }
  }
}

// Each node has at most one parent, so a node that was not reached lies on or below a cycle.
void NodeGraph::find_cycles() const {
  std::optional<InputError> first;
  const auto fault_of = [&](size_t node) {
    // After as many steps to the parent as there are nodes, `node` is on the cycle itself.
    for (size_t step = 0; step < nodes_.size(); ++step) node = size_t(document_.parents[node]);
    return InputError(document_.place(pointer(node)),
                      "the node is its own ancestor (a cycle of nodes)");
  };
  for (size_t i = 0; i < nodes_.size(); ++i) {
    if (reached_[i]) continue;
    if (in_scene_[i]) throw fault_of(i);
    if (first) {
      document_.faults->note_broken(pointer(i), GltfFaults::KnownFault(*first));
    } else {
      first = fault_of(i);
      document_.faults->note_broken(pointer(i), *first);
    }
  }
}

}  // namespace

void check_gltf_accessors(GltfDocument& document) {
  document.accessors.resize(document.array("accessors").size());
  uint64_t max_backed_count = 0;
  document.check_each("/accessors", [&](const json& object, const std::string& place, size_t i) {
    const GltfAccessor accessor = check_accessor(document, object, place);
    if (accessor.view >= 0) {
      max_backed_count = std::max(max_backed_count, accessor.count);
    }
    document.accessors[i] = accessor;
  });
  // Without this limit, a tiny file could declare any number of zeros (accessors without data).
  document.max_zeros = std::max(max_backed_count, document.total_bytes);
}

void check_gltf_nodes(GltfDocument& document) { NodeGraph(document).check(); }

void check_gltf_skins(GltfDocument& document) {
  const auto check = [&](const json& skin, const std::string& place, size_t) {
    const uint64_t joints = skin.at("joints").size();
    if (joints == 0) throw InputError(place + "/joints", "a skin needs at least one joint");
    const json* matrices = find_member(skin, "inverseBindMatrices");
    if (!matrices) return;
    const GltfAccessor& accessor = document.accessor(matrices->get<int>());
    if (accessor.components != 16 || accessor.component_type != 5126) {
      throw InputError(place + "/inverseBindMatrices", "expected an accessor of MAT4 floats");
    }
    if (accessor.count < joints) {
      throw InputError(place + "/inverseBindMatrices", "found {} matrices for {} joints",
                       accessor.count, joints);
    }
  };
  document.check_each("/skins", check);
}

void check_gltf_cameras_and_lights(GltfDocument& document) {
  // The object's type must be one of `types`. If the flag of the type is set, the object must have
  // a member with the type's name.
  using Types = std::initializer_list<std::pair<const char*, bool>>;
  const auto check = [](const json& object, const std::string& place, Types types) {
    const std::string type = object.at("type").get<std::string>();
    const auto found = std::ranges::find(types, type, &Types::value_type::first);
    if (found == types.end()) {
      std::vector<std::string_view> names;
      for (const auto& [name, parameters] : types) names.push_back(name);
      throw InputError(place + "/type", "unknown type \"{}\", expected one of {}", shortened(type),
                       fmt::join(names, ", "));
    }
    if (found->second && !object.contains(type)) {
      throw InputError(place, "the required member \"{}\" is missing", type);
    }
  };
  document.check_each("/cameras", [&](const json& camera, const std::string& place, size_t) {
    check(camera, place, {{"perspective", true}, {"orthographic", true}});
  });
  document.check_each(
      "/extensions/KHR_lights_punctual/lights",
      [&](const json& light, const std::string& place, size_t) {
        check(light, place, {{"point", false}, {"directional", false}, {"spot", true}});
      });
}

}  // namespace emberline
