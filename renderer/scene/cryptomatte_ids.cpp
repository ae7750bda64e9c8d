#include "renderer/scene/cryptomatte_ids.h"

#include <fmt/format.h>

#include <map>
#include <unordered_set>

#include "renderer/core/murmur3.h"

namespace emberline {
namespace {

struct Named {
  std::string name;
  uint32_t id = 0;
};

// Makes all names and ids distinct. The first occurrence of a name keeps it unless its id is taken;
// the others get a number.
std::vector<Named> tell_apart(const std::vector<std::string>& wanted) {
  std::vector<Named> named;
  std::unordered_set<uint32_t> taken;
  std::map<std::string, uint64_t> numbers;  // last number of each name
  std::vector<size_t> numbered;
  for (size_t i = 0; i < wanted.size(); ++i) {
    named.push_back({wanted[i], cryptomatte_id(wanted[i])});
    const bool first = numbers.try_emplace(wanted[i], 1).second;
    if (!first || !taken.insert(named[i].id).second) numbered.push_back(i);
  }
  for (const size_t i : numbered) {
    uint64_t& number = numbers[wanted[i]];
    do {
      named[i].name = fmt::format("{}_{}", wanted[i], ++number);
      named[i].id = cryptomatte_id(named[i].name);
    } while (!taken.insert(named[i].id).second);
  }
  return named;
}

// Objects, materials or assets.
struct Things {
  std::vector<std::string> names;   // as in the file
  std::vector<size_t> of_instance;  // index into `names`
};

Things things_by_name(const SceneDescription& scene) {
  Things things;
  std::map<std::string, size_t> known;
  for (const InstanceDescription& instance : scene.instances) {
    const auto [at, added] = known.emplace(instance.name, things.names.size());
    if (added) things.names.push_back(instance.name);
    things.of_instance.push_back(at->second);
  }
  return things;
}

// Objects, or assets (whole hierarchies).
Things things_by_node(const SceneDescription& scene, bool assets) {
  Things things;
  const auto thing_of = [&](size_t node) { return assets ? size_t(scene.nodes[node].root) : node; };
  std::vector<char> is_thing(scene.nodes.size(), 0);
  for (size_t node = 0; node < scene.nodes.size(); ++node) {
    if (scene.nodes[node].has_mesh) is_thing[thing_of(node)] = 1;
  }
  std::vector<size_t> place(scene.nodes.size());
  for (size_t node = 0; node < scene.nodes.size(); ++node) {
    place[node] = things.names.size();
    if (is_thing[node]) things.names.push_back(scene.nodes[node].name);
  }
  for (const InstanceDescription& instance : scene.instances) {
    things.of_instance.push_back(place[thing_of(size_t(instance.node))]);
  }
  return things;
}

Things materials_of(const SceneDescription& scene) {
  Things things;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string& name = scene.materials[i].name;
    things.names.push_back(name.empty() ? fmt::format("material {}", i) : name);
  }
  things.names.push_back("default");
  for (const InstanceDescription& instance : scene.instances) {
    const int material = scene.meshes[size_t(instance.mesh)].material;
    things.of_instance.push_back(material < 0 ? scene.materials.size() : size_t(material));
  }
  return things;
}

Things things_of(const SceneDescription& scene, CryptomatteKind kind) {
  if (kind == CryptomatteKind::kMaterial) return materials_of(scene);
  if (scene.nodes.empty()) return things_by_name(scene);
  return things_by_node(scene, kind == CryptomatteKind::kAsset);
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
    Things things = things_of(scene, kinds[k]);
    things.names.push_back("environment");
    const std::vector<Named> all = tell_apart(things.names);
    CryptomatteNames& names = names_.emplace_back();
    names.kind = kinds[k];
    std::vector<char> seen(all.size(), 0);
    const Named& environment = all.back();
    ids_[k] = environment.id;
    for (size_t i = 0; i < things.of_instance.size(); ++i) {
      const size_t thing = things.of_instance[i];
      const Named& named = all[thing];
      ids_[(i + 1) * kinds.size() + k] = named.id;
      if (seen[thing]++ == 0) names.ids.emplace_back(named.name, named.id);
    }
    names.ids.emplace_back(environment.name, environment.id);
  }
}

}  // namespace emberline
