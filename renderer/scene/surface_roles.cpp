#include "renderer/scene/surface_roles.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>

#include "renderer/core/errors.h"
#include "renderer/core/name_or_index.h"
#include "renderer/core/names.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using Nodes = std::vector<NodeDescription>;

// Returns for each node whether it or one of its descendants has a mesh.
std::vector<char> find_mesh_ancestors(const Nodes& nodes) {
  std::vector<char> has_mesh_below(nodes.size(), 0);
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (int at = nodes[i].has_mesh ? int(i) : -1; at >= 0 && !has_mesh_below[size_t(at)];
         at = nodes[size_t(at)].parent) {
      has_mesh_below[size_t(at)] = 1;
    }
  }
  return has_mesh_below;
}

// Escapes a name the way parse_node_names() expects.
std::string escape_name(const std::string& name) {
  std::string text;
  for (const char c : shortened(name)) {
    if (c == ',' || c == '\\') text += '\\';
    text += c;
  }
  return text;
}

// Lists names for an error message: all of them if there are few, otherwise the three nearest.
std::string nearest_names(const std::string& wanted, const Nodes& nodes,
                          const std::vector<char>& has_mesh_below) {
  constexpr size_t kMaxListed = 3, kMaxCompared = 64;
  std::set<std::pair<size_t, std::string>> nearest;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!has_mesh_below[i] || nodes[i].name.empty()) continue;
    const size_t distance = edit_distance(wanted.substr(0, kMaxCompared),
                                          std::string_view(nodes[i].name).substr(0, kMaxCompared));
    nearest.emplace(distance, nodes[i].name);
  }
  if (nearest.size() > kMaxListedNames)
    nearest.erase(std::next(nearest.begin(), kMaxListed), nearest.end());
  if (nearest.empty()) return "the file has no nodes with a mesh and a name";
  std::vector<std::string> names;
  for (const auto& [distance, name] : nearest)
    names.push_back(fmt::format("'{}'", escape_name(name)));
  return fmt::format("the nearest names are {}", fmt::join(names, ", "));
}

// Returns all nodes with that name or, if there are none, the node with that index.
std::vector<size_t> find_nodes(const std::string& wanted, const Nodes& nodes) {
  std::vector<size_t> found;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].name == wanted) found.push_back(i);
  }
  if (!found.empty()) return found;
  if (const std::optional<size_t> index = parse_index(wanted, nodes.size())) return {*index};
  return {};
}

void assign_role(const char* option, SurfaceRole role, std::string_view list, const Nodes& nodes,
                 const std::vector<char>& has_mesh_below,
                 std::vector<std::optional<SurfaceRole>>& roles) {
  const std::vector<std::string> names = parse_node_names(list);
  if (names.empty() && !list.empty())
    throw UsageError("`{}`: '{}' does not name a node", option, shortened(list));
  for (const std::string& name : names) {
    const std::vector<size_t> found = find_nodes(name, nodes);
    if (found.empty()) {
      throw UsageError("`{}`: no node '{}'; {}", option, shortened(name),
                       nearest_names(name, nodes, has_mesh_below));
    }
    if (std::ranges::none_of(found, [&](size_t node) { return has_mesh_below[node] != 0; })) {
      throw UsageError("`{}`: neither the node '{}' nor any node below it has a mesh; {}", option,
                       shortened(name), nearest_names(name, nodes, has_mesh_below));
    }
    for (const size_t node : found) {
      if (roles[node].value_or(role) != role) {
        throw UsageError(
            "`{}`: the node '{}' is already a catcher; name it in only one of the two options",
            option, shortened(name));
      }
      roles[node] = role;
    }
  }
}

// Gives each node without a role the role of its nearest ancestor that has one, or the ordinary
// role if there is none.
void inherit_roles(const Nodes& nodes, std::vector<std::optional<SurfaceRole>>& roles) {
  std::vector<size_t> path;
  for (size_t i = 0; i < nodes.size(); ++i) {
    path.clear();
    size_t at = i;
    while (!roles[at] && nodes[at].parent >= 0) {
      path.push_back(at);
      at = size_t(nodes[at].parent);
    }
    if (!roles[at]) roles[at] = SurfaceRole::kOrdinary;
    for (const size_t node : path) roles[node] = roles[at];
  }
}

}  // namespace

SurfaceRoles::SurfaceRoles(const SceneDescription& scene, std::string_view catchers,
                           std::string_view holdouts) {
  const std::vector<char> has_mesh_below = find_mesh_ancestors(scene.nodes);
  std::vector<std::optional<SurfaceRole>> roles(scene.nodes.size());
  for (size_t i = 0; i < roles.size(); ++i) {
    if (scene.nodes[i].catches_shadows) roles[i] = SurfaceRole::kCatcher;
  }
  assign_role("catcher", SurfaceRole::kCatcher, catchers, scene.nodes, has_mesh_below, roles);
  assign_role("holdout", SurfaceRole::kHoldout, holdouts, scene.nodes, has_mesh_below, roles);
  inherit_roles(scene.nodes, roles);
  for (const InstanceDescription& instance : scene.instances) {
    const bool of_node = instance.node >= 0 && size_t(instance.node) < roles.size();
    roles_.push_back(of_node ? *roles[size_t(instance.node)] : SurfaceRole::kOrdinary);
  }
}

std::vector<std::string> parse_node_names(std::string_view list) {
  std::vector<std::string> names(1);
  for (size_t i = 0; i < list.size(); ++i) {
    if (list[i] == ',') {
      names.emplace_back();
    } else {
      if (list[i] == '\\' && i + 1 < list.size() && (list[i + 1] == ',' || list[i + 1] == '\\'))
        ++i;
      names.back() += list[i];
    }
  }
  std::erase(names, "");
  return names;
}

}  // namespace emberline
