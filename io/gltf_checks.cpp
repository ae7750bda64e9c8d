// Checks of a GltfDocument that look across objects: accessors against their buffer views, the
// node graph, skins.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <utility>

#include "io/gltf_document.h"
#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

int component_size(int component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

int component_count(const std::string& type) {
  static constexpr std::pair<const char*, int> kTypes[] = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  for (const auto& [name, count] : kTypes) {
    if (type == name) return count;
  }
  return 0;
}

int checked_component_size(const json& object, const std::string& place) {
  const int64_t type = object.at("componentType").get<int64_t>();
  const int size = type < 10000 ? component_size(int(type)) : 0;
  if (size == 0) {
    throw InputError(place + "/componentType", "unknown component type {}", type);
  }
  return size;
}

// Throws unless `count` elements of `size` bytes, `stride` apart, lie within the view. All are at
// most 2^53 and the stride below 2^16; the first test keeps the product below 2^63.
void check_reach(const GltfView& view, uint64_t offset, uint64_t count, uint64_t stride,
                 uint64_t size, const std::string& place) {
  const bool absurd = count > view.size;
  if (count == 0) return;
  if (absurd || offset + (count - 1) * stride + size > view.size) {
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
    throw InputError(place + "/count", "more sparse elements than the accessor has");
  }
  const uint64_t element_size = uint64_t(accessor.component_size) * uint64_t(accessor.components);
  check_reach(document.views[size_t(sparse.index_view)], sparse.index_offset, sparse.count,
              index_size, index_size, place + "/indices");
  check_reach(document.views[size_t(sparse.value_view)], sparse.value_offset, sparse.count,
              element_size, element_size, place + "/values");
  return sparse;
}

}  // namespace

void check_gltf_accessors(GltfDocument& document) {
  const json& accessors = document.array("accessors");
  uint64_t largest_backed = 0;
  size_t i = 0;
  for (const json& object : accessors) {
    const std::string place = document.place("/accessors/" + std::to_string(i++));
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
      const json& view_object = document.json.at("bufferViews")[size_t(accessor.view)];
      accessor.stride = view_object.value("byteStride", element_size);
      if (accessor.stride < element_size) {
        throw InputError(
            place, "the byteStride of its buffer view ({}) is less than an element ({} bytes)",
            accessor.stride, element_size);
      }
      check_reach(document.views[size_t(accessor.view)], accessor.offset, accessor.count,
                  accessor.stride, element_size, place);
      largest_backed = std::max(largest_backed, accessor.count);
    }
    if (const json* sparse = find_member(object, "sparse")) {
      accessor.sparse = check_sparse(document, *sparse, accessor, place + "/sparse");
    }
    document.accessors.push_back(accessor);
  }
  // An accessor without data stands for zeros, of which a few bytes could ask for any number.
  document.most_zeros = std::max(largest_backed, document.total_bytes);
}

void check_gltf_nodes(GltfDocument& document) {
  const json& nodes = document.array("nodes");
  document.parents.assign(nodes.size(), -1);
  const auto name = [](size_t node) { return "/nodes/" + std::to_string(node); };
  for (size_t i = 0; i < nodes.size(); ++i) {
    const json* children = find_member(nodes[i], "children");
    if (!children) continue;
    for (size_t k = 0; k < children->size(); ++k) {
      const size_t child = (*children)[k].get<size_t>();
      const std::string place = document.place(name(i) + "/children/" + std::to_string(k));
      if (child == i) throw InputError(place, "node {} is its own child", i);
      if (document.parents[child] == int(i)) {
        throw InputError(place, "node {} is listed twice", child);
      }
      if (document.parents[child] >= 0) {
        throw InputError(place, "node {} already has another parent, node {}", child,
                         document.parents[child]);
      }
      document.parents[child] = int(i);
    }
  }

  // Breadth first from the roots; with one parent each, a node that is not reached hangs on a
  // cycle.
  std::vector<int>& order = document.node_order;
  order.reserve(nodes.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (document.parents[i] < 0) order.push_back(int(i));
  }
  for (size_t next = 0; next < order.size(); ++next) {
    const json* children = find_member(nodes[size_t(order[next])], "children");
    if (!children) continue;
    for (const json& child : *children) order.push_back(child.get<int>());
  }
  if (order.size() == nodes.size()) return;
  std::vector<char> reached(nodes.size(), 0);
  for (const int node : order) reached[size_t(node)] = 1;
  size_t node = size_t(std::find(reached.begin(), reached.end(), 0) - reached.begin());
  // Walking up as often as there are nodes ends on the cycle itself.
  for (size_t step = 0; step < nodes.size(); ++step) node = size_t(document.parents[node]);
  throw InputError(document.place(name(node)), "the node is its own ancestor (a cycle of nodes)");
}

void check_gltf_skins(const GltfDocument& document) {
  size_t i = 0;
  for (const json& skin : document.array("skins")) {
    const std::string place = document.place("/skins/" + std::to_string(i++));
    const uint64_t joints = skin.at("joints").size();
    if (joints == 0) throw InputError(place + "/joints", "a skin needs at least one joint");
    const json* matrices = find_member(skin, "inverseBindMatrices");
    if (!matrices) continue;
    const GltfAccessor& accessor = document.accessors[matrices->get<size_t>()];
    if (accessor.components != 16 || accessor.component_type != 5126) {
      throw InputError(place + "/inverseBindMatrices", "expected an accessor of MAT4 floats");
    }
    if (accessor.count < joints) {
      throw InputError(place + "/inverseBindMatrices", "{} matrices for {} joints", accessor.count,
                       joints);
    }
  }
}

void check_gltf_cameras_and_lights(const GltfDocument& document) {
  // The type must be one of `types`, and objects whose type has parameters must have them.
  const auto check = [&](const json& object, const std::string& pointer,
                         std::initializer_list<std::pair<const char*, bool>> types) {
    const std::string type = object.at("type").get<std::string>();
    for (const auto& [name, has_parameters] : types) {
      if (type == name) {
        if (!has_parameters || object.contains(name)) return;
        throw InputError(document.place(pointer), "the required member \"{}\" is missing", name);
      }
    }
    throw InputError(document.place(pointer + "/type"), "unknown type \"{}\", expected one of {}",
                     shortened(type), fmt::join(types | std::views::keys, ", "));
  };
  size_t i = 0;
  for (const json& camera : document.array("cameras")) {
    check(camera, "/cameras/" + std::to_string(i++),
          {{"perspective", true}, {"orthographic", true}});
  }
  const json* lights = find_extension(document.json, "KHR_lights_punctual");
  if (!lights) return;
  i = 0;
  for (const json& light : lights->at("lights")) {
    check(light, "/extensions/KHR_lights_punctual/lights/" + std::to_string(i++),
          {{"point", false}, {"directional", false}, {"spot", true}});
  }
}

}  // namespace emberline
