#include "io/gltf/geometry/mesh_uses.h"

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "io/gltf/document/extensions.h"
#include "io/gltf/materials/variants.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {

using nlohmann::json;

namespace {

std::string primitive_pointer(size_t mesh, size_t primitive) {
  return "/meshes/" + std::to_string(mesh) + "/primitives/" + std::to_string(primitive);
}

// Returns the radius of a ball around the origin that contains the mesh.
double radius_of(const MeshDescription& mesh) {
  double largest = 0.0;
  for (const Vec3f& p : mesh.positions) largest = std::max(largest, to_double(p).length());
  return largest;
}

}  // namespace

// Limits the number of accessor elements that are read to a multiple of the number that the file
// stores. This is necessary because primitives and morph targets may share accessors, and nodes may
// use a primitive in many poses. A variant counts as one element. The factor of 64 is our choice
// and is far above normal sharing.
void GltfMeshUses::check_budget(std::span<const MeshUse> uses) const {
  uint64_t backed = document_.total_bytes;
  for (const GltfAccessor& accessor : document_.accessors) {
    if (accessor.view >= 0) backed += accessor.count;
  }
  uint64_t elements = 0;
  for (const MeshUse& use : uses) {
    for (const json& primitive : document_.json->at("meshes")[use.mesh].at("primitives")) {
      elements += count_elements(primitive, use.poses);
    }
  }
  if (elements > (uint64_t(1) << 22) + backed * 64) {
    throw InputError(document_.file, "the meshes add up to " + std::to_string(elements) +
                                         " vertices and indices, too many for a file of this size");
  }
}

// Returns the number of accessor elements that are read for the primitive in `poses`.
uint64_t GltfMeshUses::count_elements(const json& primitive,
                                      std::span<const MeshPose> poses) const {
  const auto accessor = [&](const json& index) -> const GltfAccessor& {
    static const GltfAccessor none;
    return index.is_null() ? none : document_.accessors[index.get<size_t>()];
  };
  uint64_t elements = variant_material_count(primitive);
  const json* indices = find_member(primitive, "indices");
  // For Draco, the size of the stream limits the number of elements.
  const bool is_draco = find_extension(primitive, "KHR_draco_mesh_compression");
  const bool is_read = indices && (!is_draco || accessor(*indices).view >= 0);
  const uint64_t corners = is_read ? accessor(*indices).count : UINT64_MAX;
  if (corners != UINT64_MAX) elements += corners;
  const auto add = [&](const json& attributes) {
    for (const json& attribute : attributes) {
      const GltfAccessor& source = accessor(attribute);
      if (is_draco && source.view < 0) continue;
      // If there are few indices, PrimitiveReader reads only the vertices that they refer to.
      const uint64_t most = corners <= UINT64_MAX / 4 ? corners * 4 : UINT64_MAX;
      elements += std::min(source.count, most) + source.sparse.count;
    }
  };
  add(primitive.at("attributes"));
  const json* targets = find_member(primitive, "targets");
  const size_t count = std::min(targets ? targets->size() : 0, poses[0].weights.size());
  for (size_t t = 0; t < count; ++t) {
    const auto counts = [t](const MeshPose& pose) { return pose.weights[t] != 0.0; };
    if (std::ranges::any_of(poses, counts)) add((*targets)[t]);
  }
  return elements;
}

// One primitive of a MeshUse while it is being loaded.
struct GltfMeshUses::Primitive {
  MeshUse* use = nullptr;
  size_t primitive = 0;
  std::vector<TangentLayout> layouts = {};
  const StaticMesh* cached = nullptr;  // the mesh that was read for an earlier pose
  LoadedMesh result = {};
};

// Loads a primitive. If no animation deforms it and the caller still has its mesh from an earlier
// pose, uses the cache instead.
void GltfMeshUses::load(Primitive& task) const {
  static const MaterialDescription default_material;
  const MeshUse& use = *task.use;
  const json& primitive = document_.json->at("meshes")[use.mesh].at("primitives")[task.primitive];
  const std::string pointer = primitive_pointer(use.mesh, task.primitive);
  std::vector<VariantMaterial> others;
  std::optional<InputError> variants_fault;
  try {
    if (scene_.variants_read) others = read_variant_materials(document_, primitive, pointer);
  } catch (const InputError& error) {
    if (document_.requires_extension("KHR_materials_variants")) throw;
    variants_fault = error;
  }
  const int own = primitive.value("material", -1);
  const auto require = [&](int material) {
    if (material >= 0) document_.faults->require("/materials/" + std::to_string(material));
  };
  require(own);
  for (const VariantMaterial& other : others) require(other.material);
  std::vector<const MaterialDescription*> materials = {own >= 0 ? &scene_.materials[size_t(own)]
                                                                : &default_material};
  for (const VariantMaterial& other : others) {
    materials.push_back(&scene_.materials[size_t(other.material)]);
  }
  task.layouts = tangent_layouts(materials);
  const auto found =
      use.undeformed ? cache_.meshes.find({use.mesh, task.primitive, use.skin, use.node, use.flat})
                     : cache_.meshes.end();
  if (found != cache_.meshes.end() && found->second.layouts == task.layouts) {
    task.cached = &found->second;
    const bool is_empty = task.cached->key == 0;
    if (is_empty || std::ranges::binary_search(held_, task.cached->key)) {
      task.result = task.cached->loaded;
      return;
    }
  }
  task.result = load_primitive(document_, use.mesh, task.primitive, use.poses, next_frame_,
                               materials, scene_.tangents_read, use.flat);
  task.result.mesh.variant_materials = std::move(others);
  task.result.variants_fault = variants_fault;
}

// Caches the parts of the mesh that later poses can reuse. Returns null for a deforming mesh.
const StaticMesh* GltfMeshUses::cache_mesh(Primitive& task) {
  const MeshUse& use = *task.use;
  MeshDescription& mesh = task.result.mesh;
  mesh.may_move = use.may_move;
  if (!use.undeformed) {
    cache_.deforms = true;
    return nullptr;
  }
  const bool is_read = !mesh.triangles.empty();
  if (is_read) cache_.new_static_bytes += task.result.bytes;
  const GltfCache::MeshId id(use.mesh, task.primitive, use.skin, use.node, use.flat);
  if (!task.cached) {
    StaticMesh cached;
    if (is_read) cached.key = ++cache_.last_key;
    cached.layouts = std::move(task.layouts);
    cached.radius = radius_of(mesh);
    for (const Vec3f& p : mesh.positions) cached.bounds.extendBy(to_double(p));
    MeshArrays arrays = std::exchange<MeshArrays>(mesh, {});
    cached.loaded = task.result;
    static_cast<MeshArrays&>(mesh) = std::move(arrays);
    cache_.memory.add(sizeof(StaticMesh) + mesh.name.size(), document_.file);
    task.cached = &cache_.meshes.insert_or_assign(id, std::move(cached)).first->second;
  }
  mesh.key = task.cached->key;
  if (mesh.key != 0 && !is_read) mesh.reused_bounds = task.cached->bounds;
  cache_.static_bytes += task.result.bytes;
  return task.cached;
}

// Adds the primitive and its reports to the scene. Returns false if the primitive is empty.
bool GltfMeshUses::add(Primitive& task) {
  for (const std::string& what : task.result.ignored) {
    report_ignored(document_.file, what, scene_.coverage);
  }
  for (const std::string& what : task.result.approximated) {
    report_approximated(document_.file, what, scene_.coverage);
  }
  count_surfaceless(task.result, task.use->placements);
  const std::string extensions = primitive_pointer(task.use->mesh, task.primitive) + "/extensions/";
  const auto note_extension_fault = [&](const std::optional<InputError>& fault,
                                        const char* extension) {
    if (fault) document_.faults->note_defaulted(extensions + extension, *fault);
  };
  note_extension_fault(task.result.draco_fault, "KHR_draco_mesh_compression");
  note_extension_fault(task.result.variants_fault, "KHR_materials_variants");
  scene_.repairs.degenerate_triangles += task.result.repairs.degenerate_triangles;
  scene_.repairs.non_finite_triangles += task.result.repairs.non_finite_triangles;
  scene_.repairs.non_finite_attributes += task.result.repairs.non_finite_attributes;
  if (task.result.mesh.triangles.empty() && !task.result.mesh.reused_bounds) {
    const bool deforms = task.use->skin >= 0 || !task.use->poses[0].weights.empty();
    const LoadRepairs& repairs = task.result.repairs;
    if (deforms && repairs.non_finite_triangles == 0)
      collapsed_ |= repairs.degenerate_triangles > 0;
    return false;
  }
  task.use->loaded.push_back(int(scene_.meshes.size()));
  scene_.meshes.push_back(std::move(task.result.mesh));
  return true;
}

void GltfMeshUses::count_surfaceless(const LoadedMesh& loaded, uint64_t placements) {
  uint64_t& sum = loaded.mode == 0 ? points_ : lines_;
  const uint64_t placed = bytes_of(loaded.surfaceless_count, placements);
  sum += std::min(placed, UINT64_MAX - sum);
}

void GltfMeshUses::load(std::vector<MeshUse>& uses, bool at_rest) {
  check_budget(uses);
  std::vector<Primitive> tasks;
  for (MeshUse& use : uses) {
    const size_t count = document_.json->at("meshes")[use.mesh].at("primitives").size();
    for (size_t p = 0; p < count; ++p) tasks.push_back({&use, p});
  }
  document_.progress->begin(LoadStage::kMeshes, tasks.size());
  const std::vector<std::exception_ptr> errors =
      document_.try_each(tasks.size(), [&](size_t i) { load(tasks[i]); });
  // Throws the first error in file order, so that the message does not depend on timing.
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  cache_.deforms = false;
  cache_.new_static_bytes = cache_.static_bytes = 0;
  for (Primitive& task : tasks) {
    const StaticMesh* cached = cache_mesh(task);
    if (add(task)) static_meshes_.push_back(cached);
  }
  cache_.deforms = cache_.deforms && !at_rest;
}

Vec3d GltfMeshUses::center(const MeshUse& use) const {
  WorldBounds bounds;
  for (const int mesh : use.loaded) {
    if (const StaticMesh* undeformed = static_meshes_[size_t(mesh)]) {
      bounds.add(undeformed->bounds, Mat44d());
    } else {
      for (const Vec3f& p : scene_.meshes[size_t(mesh)].positions) bounds.extendBy(to_double(p));
    }
  }
  return bounds.isEmpty() ? Vec3d(0.0) : bounds.center();
}

double GltfMeshUses::radius(size_t mesh) const {
  return static_meshes_[mesh] ? static_meshes_[mesh]->radius : radius_of(scene_.meshes[mesh]);
}

}  // namespace emberline
