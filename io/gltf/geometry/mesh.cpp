#include "io/gltf/geometry/mesh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "io/gltf/geometry/deform.h"
#include "io/gltf/geometry/primitive.h"
#include "io/gltf/geometry/tangents.h"
#include "io/gltf/materials/material.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

using nlohmann::json;
using Triangle = std::array<uint32_t, 3>;

constexpr const char* kModeNames[] = {"POINTS",    "LINES",          "LINE_LOOP",   "LINE_STRIP",
                                      "TRIANGLES", "TRIANGLE_STRIP", "TRIANGLE_FAN"};
enum Mode { kPoints, kLines, kLineLoop, kLineStrip, kTriangles, kTriangleStrip, kTriangleFan };

// Grain of parallel loops over vertices or triangles: about 100 microseconds of work.
constexpr size_t kMeshGrain = size_t(1) << 14;

// Returns the number of points or lines that a primitive draws, or 0 if its accessor is broken.
uint64_t count_points_or_lines(const GltfDocument& document, const json& primitive, int mode) {
  const json* list = find_member(primitive, "indices");
  if (!list) list = find_member(primitive.at("attributes"), "POSITION");
  if (!list || list->is_null()) return 0;
  const uint64_t count = document.accessors[list->get<size_t>()].count;
  if (mode == kPoints) return count;
  if (count < 2) return 0;
  return mode == kLines ? count / 2 : mode == kLineStrip ? count - 1 : count;
}

// Follows specification section 3.7.2.1: every second triangle of a strip is reversed, and the hub
// of a fan is the last vertex of each triangle. Surplus vertices at the end are ignored.
std::vector<Triangle> to_triangle_list(PrimitiveReader& reader, int mode) {
  if (mode == kTriangles || reader.is_draco()) return reader.take_triangles();
  const std::span<const uint32_t> indices = reader.indices();
  std::vector<Triangle> triangles;
  triangles.reserve(indices.size());
  for (size_t i = 0; i + 2 < indices.size(); ++i) {
    if (mode == kTriangleFan) {
      triangles.push_back({indices[i + 1], indices[i + 2], indices[0]});
    } else {
      const size_t odd = i % 2;
      triangles.push_back({indices[i], indices[i + 1 + odd], indices[i + 2 - odd]});
    }
  }
  return triangles;
}

// Two edges count as collinear if their cross product, divided by the square of the longest edge,
// is below this limit. The value is the rounding error of the product in double, a few times 2^-53.
constexpr double kCollinear = 1e-15;

bool is_degenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d e1 = b - a, e2 = c - a, e3 = c - b;
  const double longest2 = std::max(dot(e1, e1), std::max(dot(e2, e2), dot(e3, e3)));
  const Vec3d normal = cross(e1, e2);
  return !(std::sqrt(dot(normal, normal)) > kCollinear * longest2);
}

// Larger coordinates overflow when squared in float, so intersections with rays would fail.
constexpr float kMaxCoordinate = 1e18f;

bool is_usable(const Vec3f& p) { return is_finite(p) && max_abs_component(p) <= kMaxCoordinate; }

// Drops triangles that have an unusable corner in at least one step, and triangles whose area is
// zero in every step.
void drop_bad_triangles(MeshDescription& mesh, LoadRepairs& repairs) {
  std::vector<const std::vector<Vec3f>*> steps = {&mesh.positions};
  for (const MeshStep& step : mesh.motion) steps.push_back(&step.positions);
  enum class Fault { kNone, kNotFinite, kDegenerate };
  const auto fault_of = [&](const Triangle& t) {
    const auto has_unusable_corner = [&](const std::vector<Vec3f>* p) {
      return !is_usable((*p)[t[0]]) || !is_usable((*p)[t[1]]) || !is_usable((*p)[t[2]]);
    };
    const auto has_no_area = [&](const std::vector<Vec3f>* p) {
      return is_degenerate(Vec3d((*p)[t[0]]), Vec3d((*p)[t[1]]), Vec3d((*p)[t[2]]));
    };
    if (std::ranges::any_of(steps, has_unusable_corner)) return Fault::kNotFinite;
    return std::ranges::all_of(steps, has_no_area) ? Fault::kDegenerate : Fault::kNone;
  };
  // Most meshes have no bad triangles, so a parallel search comes first.
  std::atomic<bool> any = false;
  parallel_each(mesh.triangles.size(), kMeshGrain, [&](size_t i) {
    if (fault_of(mesh.triangles[i]) != Fault::kNone) any.store(true, std::memory_order_relaxed);
  });
  if (!any) return;
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Fault fault = fault_of(t);
    repairs.non_finite_triangles += fault == Fault::kNotFinite;
    repairs.degenerate_triangles += fault == Fault::kDegenerate;
    return fault != Fault::kNone;
  });
}

// Keeps only the vertices that triangles use. Some writers share one vertex buffer among a hundred
// primitives, and an unused NaN must not reach a bounding box.
void drop_unused_vertices(MeshDescription& mesh) {
  std::vector<uint8_t> is_used(mesh.positions.size(), 0);  // bytes, to stay in the cache
  for (const Triangle& t : mesh.triangles) {
    for (const uint32_t v : t) is_used[v] = 1;
  }
  if (std::ranges::find(is_used, 0) == is_used.end()) return;
  constexpr uint32_t kUnused = UINT32_MAX;
  uint32_t used = 0;
  std::vector<uint32_t> renumbered(is_used.size(), kUnused);
  for (size_t v = 0; v < renumbered.size(); ++v) {
    if (is_used[v]) renumbered[v] = used++;
  }
  const auto compact = [&](auto& values) {
    if (values.empty()) return;
    for (size_t v = 0; v < renumbered.size(); ++v) {
      if (renumbered[v] != kUnused) values[renumbered[v]] = values[v];
    }
    values.resize(used);
    values.shrink_to_fit();
  };
  for_each_vertex_array(mesh, compact);
  for (Triangle& t : mesh.triangles) {
    for (uint32_t& v : t) v = renumbered[v];
  }
}

// Finds vertices that have a NaN or infinity in any attribute other than the position.
class VertexFaults {
 public:
  // `values` are the values of one attribute, vertex by vertex.
  void find_non_finite(std::span<const float> values, size_t components);
  template <class Vector>
  void find_non_finite(const std::vector<Vector>& values) {
    constexpr size_t kComponents = sizeof(Vector) / sizeof(float);
    find_non_finite({reinterpret_cast<const float*>(values.data()), values.size() * kComponents},
                    kComponents);
  }
  // Returns how many of the faulty vertices the triangles use.
  uint64_t count(std::span<const Triangle> triangles) const;

 private:
  std::vector<uint8_t> is_faulty_;  // empty: no faults
};

void VertexFaults::find_non_finite(std::span<const float> values, size_t components) {
  // Most attributes have no fault, so a fast test comes first: x * 0 is 0, or NaN if x is not
  // finite.
  constexpr size_t kAtOnce = 16;
  float sums[kAtOnce] = {};
  size_t next = 0;
  for (; next + kAtOnce <= values.size(); next += kAtOnce) {
    for (size_t k = 0; k < kAtOnce; ++k) sums[k] += values[next + k] * 0.0f;
  }
  for (; next < values.size(); ++next) sums[0] += values[next] * 0.0f;
  if (std::ranges::all_of(sums, [](float sum) { return sum == 0.0f; })) return;
  is_faulty_.resize(std::max(is_faulty_.size(), values.size() / components));
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) is_faulty_[i / components] = 1;
  }
}

uint64_t VertexFaults::count(std::span<const Triangle> triangles) const {
  if (is_faulty_.empty()) return 0;
  std::vector<uint8_t> left = is_faulty_;
  uint64_t count = 0;
  for (const Triangle& triangle : triangles) {
    for (const uint32_t v : triangle) {
      count += left[v];
      left[v] = 0;
    }
  }
  return count;
}

using Materials = std::span<const MaterialDescription* const>;

std::set<int> used_uv_sets(Materials materials) {
  std::set<int> used;
  for (const MaterialDescription* material : materials) {
    for (const TextureRef* texture : texture_slots(*material)) {
      if (texture->image >= 0) used.insert(texture->uv_set);
    }
  }
  return used;
}

// Reads the UV sets that materials use. A missing set becomes (0, 0) everywhere.
void read_uv_sets(const PrimitiveReader& reader, Materials materials, LoadedMesh& loaded,
                  VertexFaults& faults) {
  MeshDescription& mesh = loaded.mesh;
  const std::set<int> used = used_uv_sets(materials);
  // If a material refers to a higher set, it is rejected later, when it is compiled.
  constexpr int kMaxUvSets = 16;
  const int last = used.empty() ? 0 : std::min(*used.rbegin(), kMaxUvSets);
  for (int set = 0; set <= last; ++set) {
    const std::string name = "TEXCOORD_" + std::to_string(set);
    std::vector<Vec2f> uv;
    if (used.contains(set) ? reader.has(name) : set == 0 && reader.is_intact(name)) {
      uv = reader.vectors<Vec2f>(name);
    } else if (used.contains(set)) {
      uv.assign(mesh.positions.size(), Vec2f(0.0f));
      loaded.ignored.push_back("textures on " + mesh.name + ", which has no " + name);
    }
    faults.find_non_finite(uv);
    for (Vec2f& v : uv) {
      if (!std::isfinite(v.x) || !std::isfinite(v.y)) v = Vec2f(0.0f);
    }
    mesh.uv_sets.push_back(std::move(uv));
  }
}

void read_colors(const PrimitiveReader& reader, MeshDescription& mesh, VertexFaults& faults) {
  if (!reader.has("COLOR_0")) return;
  const int components = reader.components("COLOR_0") == 3 ? 3 : 4;
  const std::vector<float> values = reader.floats("COLOR_0", components);
  faults.find_non_finite(values, size_t(components));
  mesh.colors.assign(mesh.positions.size(), Vec4f(1.0f));
  for (size_t i = 0; i < mesh.colors.size(); ++i) {
    for (int c = 0; c < components; ++c) {
      const float value = values[i * size_t(components) + size_t(c)];
      // The comparison is also false for NaN.
      mesh.colors[i][c] = value > 0.0f ? value : 0.0f;
    }
  }
}

// Specification 3.7.2.1 and 3.7.2.2 require that colours are clamped to [0, 1] after morphing.
void clamp_colors(std::vector<Vec4f>& colors) {
  for (Vec4f& color : colors) {
    for (int c = 0; c < 4; ++c) color[c] = color[c] > 0.0f ? std::min(color[c], 1.0f) : 0.0f;
  }
}

// Returns the texture whose UVs determine a material's tangents. Without such a texture, the result
// stands for untransformed TEXCOORD_0.
TextureRef tangent_layout(const MaterialDescription& material) {
  for (const TextureRef* texture : {&material.normal_texture, &material.clearcoat_normal_texture,
                                    &material.anisotropy_texture}) {
    if (texture->image >= 0) return *texture;
  }
  return {};
}

// Returns the layout of the first material that needs tangents. If no material does, returns the
// layout of the first material if `required`, and otherwise nothing.
std::optional<TextureRef> find_tangent_layout(const PrimitiveReader& reader, Materials materials,
                                              bool required, LoadedMesh& loaded) {
  std::optional<TextureRef> found;
  for (const MaterialDescription* material : materials) {
    if (!has_tangent_space(*material)) continue;
    const TextureRef layout = tangent_layout(*material);
    if (!found) found = layout;
    if (layout.image < 0 && !reader.has("TANGENT") && !reader.has("TEXCOORD_0")) {
      loaded.approximated.push_back("anisotropy on " + loaded.mesh.name +
                                    ", which has neither TANGENT nor TEXCOORD_0 to orient it");
    }
    if (layout.uv_set == found->uv_set && layout.uv_transform == found->uv_transform) continue;
    loaded.approximated.push_back("normal maps of variants on " + loaded.mesh.name +
                                  " that use different texture coordinates from the first variant");
    break;
  }
  if (!found && required) found = tangent_layout(*materials.front());
  return found;
}

// `vertices` is a mesh or a motion step.
void normalise_directions(auto& vertices) {
  parallel_each(vertices.normals.size(), kMeshGrain, [&](size_t i) {
    vertices.normals[i] = normalize_or(vertices.normals[i], Vec3f(0.0f));
  });
  parallel_each(vertices.tangents.size(), kMeshGrain, [&](size_t i) {
    Vec4f& t = vertices.tangents[i];
    const Vec3f unit = normalize_or(Vec3f(t.x, t.y, t.z), Vec3f(0.0f));
    t = is_black(unit) ? arbitrary_tangent(vertices.normals[i])
                       : Vec4f(unit.x, unit.y, unit.z, t.w < 0.0f ? -1.0f : 1.0f);
  });
}

// If the later position of a vertex is unusable, replaces it by the current position.
std::vector<Vec3f> replace_unusable(std::vector<Vec3f> next_frame,
                                    const std::vector<Vec3f>& positions) {
  for (size_t v = 0; v < next_frame.size(); ++v) {
    if (!is_usable(next_frame[v])) next_frame[v] = positions[v];
  }
  return next_frame;
}

// Deforms the mesh from its rest pose into `poses`.
void apply_poses(const PrimitiveReader& reader, const GltfDocument& document, const json& primitive,
                 const std::string& pointer, std::span<const MeshPose> poses, bool next_frame,
                 MeshDescription& mesh) {
  MeshDescription unposed;
  if (poses.size() > 1) {
    unposed.positions = mesh.positions;
    if (!next_frame) {
      unposed.normals = mesh.normals;
      unposed.tangents = mesh.tangents;
    }
  }
  const auto apply = [&](const MeshPose& pose, MeshDescription& posed) {
    document.progress->check();
    apply_morph_targets(reader, document, primitive, pointer, pose.weights, posed);
    apply_skin(reader, document, pointer, pose.joints, posed);
  };
  apply(poses[0], mesh);
  for (const MeshPose& pose : poses.subspan(1)) {
    MeshDescription posed = unposed;
    apply(pose, posed);
    if (next_frame) {
      mesh.next_frame = replace_unusable(std::move(posed.positions), mesh.positions);
      continue;
    }
    mesh.motion.push_back(
        {std::move(posed.positions), std::move(posed.normals), std::move(posed.tangents)});
  }
}

// Whether morph targets make colours or UVs differ between the poses. A mesh holds colours and UVs
// constant while the shutter is open.
bool morphs_held_attributes(const json& primitive, std::span<const MeshPose> poses) {
  const json* targets = find_member(primitive, "targets");
  if (!targets) return false;
  for (size_t t = 0; t < targets->size(); ++t) {
    const auto weight = [t](const MeshPose& pose) {
      return t < pose.weights.size() ? pose.weights[t] : 0.0;
    };
    const bool changes = std::ranges::any_of(
        poses, [&](const MeshPose& pose) { return weight(pose) != weight(poses[0]); });
    if (!changes) continue;
    for (const auto& [name, accessor] : (*targets)[t].items()) {
      if (name == "COLOR_0" || name.starts_with("TEXCOORD_")) return true;
    }
  }
  return false;
}

// Returns an upper bound on the memory that load_primitive() uses at any time, including the
// result. The bound follows from the counts that the primitive declares.
uint64_t max_load_bytes(const GltfDocument& document, const PrimitiveReader& reader,
                        const json& primitive, std::span<const MeshPose> poses, Materials materials,
                        bool generates_tangents) {
  const uint64_t vertices = reader.vertex_count();
  uint64_t per_vertex = sizeof(Vec3f) + sizeof(Vec4f) + sizeof(uint32_t);  // with temporaries
  if (reader.has("NORMAL")) per_vertex += sizeof(Vec3f);
  if (reader.has("TANGENT")) per_vertex += sizeof(Vec4f);
  if (reader.has("COLOR_0")) per_vertex += sizeof(Vec4f);
  per_vertex += sizeof(Vec2f) * (1 + used_uv_sets(materials).size());
  if (!poses[0].joints.empty()) per_vertex += sizeof(Mat44d) + sizeof(double) + sizeof(Vec4f);
  // Covers the motion steps and a copy of the undeformed vertices.
  if (poses.size() > 1) per_vertex += poses.size() * (2 * sizeof(Vec3f) + sizeof(Vec4f));
  // generate_tangents() needs memory for groups and for up to twice as many vertices.
  if (generates_tangents) per_vertex = 2 * per_vertex + 256;
  const json* member = find_member(primitive, "indices");
  const uint64_t indices = member ? document.accessor(member->get<int>()).count : vertices;
  const bool list = primitive.value("mode", int(kTriangles)) == kTriangles;
  // A triangle list needs no second copy of its indices.
  uint64_t per_index = sizeof(uint32_t) + (reader.is_draco() ? sizeof(uint32_t)
                                           : list            ? 0
                                                             : sizeof(Triangle));
  // If tangents are generated for flat faces, the faces do not share vertices.
  if (generates_tangents && !reader.has("NORMAL")) per_index += per_vertex;
  return bytes_of(vertices, per_vertex) + bytes_of(indices, per_index);
}

// Whether the primitive has a surface. If it has none, stores the reason in `loaded`.
bool has_surface(const GltfDocument& document, const json& primitive, LoadedMesh& loaded) {
  const int mode = primitive.value("mode", int(kTriangles));
  if (mode < kTriangles) {
    loaded.ignored.push_back(std::string("primitive mode ") + kModeNames[mode] +
                             " (has no surface)");
    loaded.mode = mode;
    loaded.surfaceless_count = count_points_or_lines(document, primitive, mode);
    return false;
  }
  if (!primitive.at("attributes").contains("POSITION")) {
    loaded.ignored.push_back("a primitive without POSITION");
    return false;
  }
  return true;
}

std::string mesh_name(const json& mesh, size_t index) {
  const std::string name = mesh.value("name", "");
  return name.empty() ? "mesh " + std::to_string(index) : name;
}

}  // namespace

std::vector<TangentLayout> tangent_layouts(Materials materials) {
  std::vector<TangentLayout> layouts;
  for (const MaterialDescription* material : materials) {
    const TextureRef layout = tangent_layout(*material);
    layouts.push_back({has_tangent_space(*material), layout.uv_set, layout.uv_transform});
  }
  return layouts;
}

LoadedMesh load_primitive(const GltfDocument& document, size_t mesh_index, size_t primitive_index,
                          std::span<const MeshPose> poses, bool next_frame, Materials materials,
                          bool tangents, bool flat) {
  const json& mesh_object = document.json->at("meshes")[mesh_index];
  const json& primitive = mesh_object.at("primitives")[primitive_index];
  const std::string pointer =
      "/meshes/" + std::to_string(mesh_index) + "/primitives/" + std::to_string(primitive_index);

  LoadedMesh loaded;
  MeshDescription& mesh = loaded.mesh;
  mesh.name = mesh_name(mesh_object, mesh_index) + "/" + std::to_string(primitive_index);
  mesh.material = primitive.value("material", -1);

  if (!has_surface(document, primitive, loaded)) return loaded;

  PrimitiveReader reader(document, primitive, pointer);
  loaded.draco_fault = reader.draco_fault();
  const std::optional<TextureRef> layout = find_tangent_layout(reader, materials, tangents, loaded);
  // Specification 3.7.2.1 requires that supplied tangents are ignored if there are no normals.
  const bool has_normals = !flat && reader.has("NORMAL");
  const bool has_tangents = layout && has_normals && reader.has("TANGENT");
  MemoryReservation memory(
      document.progress->budget(), MemoryPart::kGeometry,
      max_load_bytes(document, reader, primitive, poses, materials, layout && !has_tangents),
      document.place(pointer));
  mesh.positions = reader.vectors<Vec3f>("POSITION", 1);  // Embree reads past the last position
  if (mesh.positions.size() >= UINT32_MAX) {
    throw InputError(document.place(pointer), "more vertices than a 32-bit index can address");
  }
  if (has_normals) mesh.normals = reader.vectors<Vec3f>("NORMAL");
  if (has_tangents) mesh.tangents = reader.vectors<Vec4f>("TANGENT");
  VertexFaults faults;
  read_uv_sets(reader, materials, loaded, faults);
  read_colors(reader, mesh, faults);
  if (reader.has("COLOR_1")) loaded.ignored.push_back("COLOR_1 (only COLOR_0 is supported)");

  apply_poses(reader, document, primitive, pointer, poses, next_frame, mesh);
  if (!next_frame && morphs_held_attributes(primitive, poses)) {
    loaded.approximated.push_back(
        "morphed colours and texture coordinates (held while the shutter is open)");
  }
  faults.find_non_finite(mesh.normals);
  faults.find_non_finite(mesh.tangents);
  faults.find_non_finite(mesh.colors);
  clamp_colors(mesh.colors);

  mesh.triangles = to_triangle_list(reader, primitive.value("mode", int(kTriangles)));
  drop_bad_triangles(mesh, loaded.repairs);
  loaded.repairs.non_finite_attributes = faults.count(mesh.triangles);
  drop_unused_vertices(mesh);
  normalise_directions(mesh);
  for (MeshStep& step : mesh.motion) normalise_directions(step);
  if (layout && mesh.tangents.empty()) generate_tangents(mesh, *layout);
  // Replaces the reservation for reading by that of the finished mesh.
  memory.release();
  loaded.bytes = mesh.name.capacity() + allocated_bytes(mesh);
  document.reserve(MemoryPart::kGeometry, loaded.bytes, document.place(pointer));
  return loaded;
}

}  // namespace emberline
