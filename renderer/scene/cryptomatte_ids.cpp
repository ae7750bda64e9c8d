#include "renderer/scene/cryptomatte_ids.h"

#include <fmt/format.h>

#include <map>
#include <unordered_set>

#include "renderer/core/murmur3.h"

namespace emberline {
namespace {

struct NamedId {
  std::string name;
  uint32_t id = 0;
};

// Makes all names and ids distinct. The first entity with a name keeps the name, unless its id is
// already taken. The others get a number appended.
std::vector<NamedId> make_names_unique(const std::vector<std::string>& requested) {
  std::vector<NamedId> named;
  std::unordered_set<uint32_t> taken;
  std::map<std::string, uint64_t> numbers;  // last number appended to each name
  std::vector<size_t> numbered;
  for (size_t i = 0; i < requested.size(); ++i) {
    named.push_back({requested[i], cryptomatte_id(requested[i])});
    const bool first = numbers.try_emplace(requested[i], 1).second;
    if (!first || !taken.insert(named[i].id).second) numbered.push_back(i);
  }
  for (const size_t i : numbered) {
    uint64_t& number = numbers[requested[i]];
    do {
      named[i].name = fmt::format("{}_{}", requested[i], ++number);
      named[i].id = cryptomatte_id(named[i].name);
    } while (!taken.insert(named[i].id).second);
  }
  return named;
}

// The objects, materials or assets of a scene.
struct Entities {
  std::vector<std::string> names;          // as in the file
  std::vector<size_t> entity_of_instance;  // index into `names`
};

Entities entities_by_name(const SceneDescription& scene) {
  Entities entities;
  std::map<std::string, size_t> known;
  for (const InstanceDescription& instance : scene.instances) {
    const auto [at, added] = known.emplace(instance.name, entities.names.size());
    if (added) entities.names.push_back(instance.name);
    entities.entity_of_instance.push_back(at->second);
  }
  return entities;
}

// Returns the assets (whole hierarchies) or, if `assets` is false, the objects.
Entities entities_by_node(const SceneDescription& scene, bool assets) {
  Entities entities;
  const auto entity_of_node = [&](size_t node) {
    return assets ? size_t(scene.nodes[node].root) : node;
  };
  std::vector<char> is_entity(scene.nodes.size(), 0);
  for (size_t node = 0; node < scene.nodes.size(); ++node) {
    if (scene.nodes[node].has_mesh) is_entity[entity_of_node(node)] = 1;
  }
  std::vector<size_t> entity_index(scene.nodes.size());
  for (size_t node = 0; node < scene.nodes.size(); ++node) {
    entity_index[node] = entities.names.size();
    if (is_entity[node]) entities.names.push_back(scene.nodes[node].name);
  }
  for (const InstanceDescription& instance : scene.instances) {
    entities.entity_of_instance.push_back(entity_index[entity_of_node(size_t(instance.node))]);
  }
  return entities;
}

Entities materials_of(const SceneDescription& scene) {
  Entities entities;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string& name = scene.materials[i].name;
    entities.names.push_back(name.empty() ? fmt::format("material {}", i) : name);
  }
  entities.names.push_back("default");
  for (const InstanceDescription& instance : scene.instances) {
    const int material = scene.meshes[size_t(instance.mesh)].material;
    entities.entity_of_instance.push_back(material < 0 ? scene.materials.size() : size_t(material));
  }
  return entities;
}

Entities entities_of_kind(const SceneDescription& scene, CryptomatteKind kind) {
  if (kind == CryptomatteKind::kMaterial) return materials_of(scene);
  if (scene.nodes.empty()) return entities_by_name(scene);
  return entities_by_node(scene, kind == CryptomatteKind::kAsset);
}

}  // namespace

uint32_t cryptomatte_id(std::string_view name) {
  const uint32_t hash = murmur3_32(name), exponent = hash >> 23 & 0xffu;
  return exponent == 0 || exponent == 0xff ? hash ^ 1u << 23 : hash;
}

CryptomatteIds::CryptomatteIds(const SceneDescription& scene,
                               std::span<const CryptomatteKind> kinds) {
  ids_.resize((scene.instances.size() + 1) * kinds.size());
  for (size_t k = 0; k < kinds.size(); ++k) {
    Entities entities = entities_of_kind(scene, kinds[k]);
    entities.names.push_back("environment");
    const std::vector<NamedId> all = make_names_unique(entities.names);
    CryptomatteNames& names = names_.emplace_back();
    names.kind = kinds[k];
    std::vector<char> seen(all.size(), 0);
    const NamedId& environment = all.back();
    ids_[k] = environment.id;
    for (size_t i = 0; i < entities.entity_of_instance.size(); ++i) {
      const size_t entity = entities.entity_of_instance[i];
      const NamedId& named = all[entity];
      ids_[(i + 1) * kinds.size() + k] = named.id;
      if (seen[entity]++ == 0) names.ids.emplace_back(named.name, named.id);
    }
    names.ids.emplace_back(environment.name, environment.id);
  }
}

}  // namespace emberline
