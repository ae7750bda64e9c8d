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

// Names that differ, and whose ids do.
class UniqueNames {
 public:
  Named add(const std::string& wanted) {
    Named named = {wanted, cryptomatte_id(wanted)};
    // A file of many equal names asks for the number after the last.
    uint64_t& number = numbers_.try_emplace(wanted, 1).first->second;
    while (!taken_.insert(named.id).second) {
      named.name = fmt::format("{}_{}", wanted, ++number);
      named.id = cryptomatte_id(named.name);
    }
    return named;
  }

 private:
  std::unordered_set<uint32_t> taken_;
  std::map<std::string, uint64_t> numbers_;
};

// Things by number, in the order that their names are claimed in.
struct Things {
  std::vector<Named> named;         // empty names: it has none
  std::vector<size_t> of_instance;  // into `named`
  Named environment;
};

Things things_by_name(const SceneDescription& scene) {
  Things things;
  UniqueNames unique;
  std::map<std::string, size_t> known;
  for (const InstanceDescription& instance : scene.instances) {
    const auto [at, added] = known.emplace(instance.name, things.named.size());
    if (added) things.named.push_back(unique.add(instance.name));
    things.of_instance.push_back(at->second);
  }
  things.environment = unique.add("environment");
  return things;
}

// `thing_of` says of each node which node is the thing that it belongs to.
Things things_by_node(const SceneDescription& scene, const std::vector<int>& thing_of) {
  Things things;
  UniqueNames unique;
  things.named.resize(scene.nodes.size());
  std::vector<char> is_thing(scene.nodes.size(), 0);
  for (size_t node = 0; node < scene.nodes.size(); ++node) {
    if (scene.nodes[node].has_mesh) is_thing[size_t(thing_of[node])] = 1;
  }
  for (size_t node = 0; node < scene.nodes.size(); ++node) {
    if (is_thing[node]) things.named[node] = unique.add(scene.nodes[node].name);
  }
  for (const InstanceDescription& instance : scene.instances) {
    things.of_instance.push_back(size_t(thing_of[size_t(instance.node)]));
  }
  things.environment = unique.add("environment");
  return things;
}

Things materials_of(const SceneDescription& scene) {
  Things things;
  UniqueNames unique;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const std::string& name = scene.materials[i].name;
    things.named.push_back(unique.add(name.empty() ? fmt::format("material {}", i) : name));
  }
  things.named.push_back(unique.add("default"));
  for (const InstanceDescription& instance : scene.instances) {
    const int material = scene.meshes[size_t(instance.mesh)].material;
    things.of_instance.push_back(material < 0 ? scene.materials.size() : size_t(material));
  }
  things.environment = unique.add("environment");
  return things;
}

Things things_of(const SceneDescription& scene, CryptomatteKind kind) {
  if (kind == CryptomatteKind::kMaterial) return materials_of(scene);
  if (scene.nodes.empty()) return things_by_name(scene);
  std::vector<int> thing_of(scene.nodes.size());
  for (size_t node = 0; node < thing_of.size(); ++node) {
    int top = int(node);
    if (kind == CryptomatteKind::kAsset) top = scene.nodes[node].root;
    thing_of[node] = top;
  }
  return things_by_node(scene, thing_of);
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
    const Things things = things_of(scene, kinds[k]);
    CryptomatteNames& names = names_.emplace_back();
    names.kind = kinds[k];
    std::vector<char> seen(things.named.size(), 0);
    ids_[k] = things.environment.id;
    for (size_t i = 0; i < things.of_instance.size(); ++i) {
      const size_t thing = things.of_instance[i];
      const Named& named = things.named[thing];
      ids_[(i + 1) * kinds.size() + k] = named.id;
      if (seen[thing]++ == 0) names.ids.emplace_back(named.name, named.id);
    }
    names.ids.emplace_back(things.environment.name, things.environment.id);
  }
}

}  // namespace emberline
