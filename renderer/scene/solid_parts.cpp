// Finds solids made of several meshes: the parts of a node's mesh that only together form a closed
// surface.
#include <algorithm>
#include <map>

#include "renderer/scene/scene.h"
#include "renderer/scene/solids.h"

namespace emberline {

using scene_detail::Instance;
using scene_detail::Mesh;
using scene_detail::shape_of;
using scene_detail::SolidShape;

namespace {

// Returns whether both materials refract and absorb light alike. Roughness does not matter, so a
// partly frosted bottle is one solid.
bool have_same_medium(const Material& a, const Material& b) {
  return a.ior() == b.ior() && a.dispersion() == b.dispersion() &&
         a.attenuation() == b.attenuation();
}

// Returns whether every ray that hits the mesh ends there, from either side.
bool is_opaque(const Mesh& mesh) {
  return !mesh.triangles.empty() && !mesh.material->is_transmissive() && !mesh.has_coverage &&
         !mesh.cull_backfaces;
}

bool have_same_placement(const InstanceDescription& a, const InstanceDescription& b) {
  return a.node >= 0 && a.node == b.node && a.to_world == b.to_world;
}

}  // namespace

std::vector<uint32_t> Solids::parts_of(uint32_t body) const {
  const auto found = parts_.find(body);
  return found == parts_.end() ? std::vector<uint32_t>{body} : found->second;
}

// Joins only parts with the same medium: with two media, no wall would show where one ends and the
// other begins. Opaque parts may help to close a solid.
void Solids::join_parts(const Scene& scene, const SceneDescription& description,
                        LoadProgress& progress) {
  using Parts = std::vector<uint32_t>;  // instances
  const auto mesh_of = [&](uint32_t i) -> const Mesh& {
    return scene.meshes_[scene.instances_[i].mesh];
  };
  std::map<Parts, SolidShape> known;  // keyed by mesh, since several nodes may share meshes
  const auto shape = [&](const Parts& parts, bool is_solid) -> const SolidShape& {
    Parts key;
    std::vector<const Mesh*> meshes;
    for (const uint32_t i : parts) {
      key.push_back(scene.instances_[i].mesh);
      meshes.push_back(&mesh_of(i));
    }
    const auto [entry, is_new] = known.try_emplace(key);
    if (is_new) {
      const std::string& name = description.meshes[key[0]].name;
      entry->second = shape_of(meshes, is_solid ? &name : nullptr, progress);
    }
    return entry->second;
  };
  // Joins the parts into one body. Returns false if they do not form a closed surface together.
  const auto join = [&](const Parts& solid, const Parts& opaque) {
    Parts parts = solid;
    parts.insert(parts.end(), opaque.begin(), opaque.end());
    if (parts.size() < 2 || !shape(parts, true).closed) return false;
    for (const uint32_t i : solid) {
      set_shape(scene, i, shape(parts, true));
      solids_[i].body = solid[0];
    }
    for (const uint32_t i : opaque) opaque_parts_[i] = solid[0];
    parts_[solid[0]] = std::move(parts);
    return true;
  };
  const auto belong_together = [&](uint32_t a, uint32_t b) {
    return have_same_placement(description.instances[a], description.instances[b]) &&
           scene.instances_[a].transformed == scene.instances_[b].transformed;
  };
  for (uint32_t begin = 0, end = 0; begin < scene.instances_.size(); begin = end) {
    for (end = begin + 1; end < scene.instances_.size() && belong_together(begin, end);) ++end;
    if (end - begin < 2) continue;
    Parts open, opaque;
    for (uint32_t i = begin; i < end; ++i) {
      const bool is_solid = !mesh_of(i).triangles.empty() && mesh_of(i).material->is_solid();
      if (is_solid && !solids_[i].closed) open.push_back(i);
      if (!is_solid && is_opaque(mesh_of(i))) opaque.push_back(i);
    }
    while (!open.empty()) {
      const Material& first = *mesh_of(open[0]).material;
      const auto others = std::ranges::stable_partition(
          open, [&](uint32_t i) { return have_same_medium(*mesh_of(i).material, first); });
      const Parts same(open.begin(), others.begin());
      open.assign(others.begin(), others.end());
      if (join(same, {}) || opaque.empty()) continue;
      // An opaque mesh that is closed by itself, such as a cork, is not a part of the solid.
      std::erase_if(opaque, [&](uint32_t i) { return shape({i}, false).closed; });
      if (!opaque.empty() && join(same, opaque)) opaque.clear();
    }
  }
}

}  // namespace emberline
