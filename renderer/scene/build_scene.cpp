#include "renderer/scene/build_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/lights/environment_light.h"
#include "renderer/scene/flush_emitters.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/required_features.h"

namespace emberline {

using scene_detail::Affine;
using scene_detail::Instance;
using scene_detail::Mesh;

namespace {

Vec3d transform_vector(const Mat44d& m, const Vec3d& v) {
  return {v.x * m[0][0] + v.y * m[1][0] + v.z * m[2][0],
          v.x * m[0][1] + v.y * m[1][1] + v.z * m[2][1],
          v.x * m[0][2] + v.y * m[1][2] + v.z * m[2][2]};
}

double determinant3(const Mat44d& m) {
  return Vec3d(m[0][0], m[0][1], m[0][2])
      .dot(Vec3d(m[1][0], m[1][1], m[1][2]).cross(Vec3d(m[2][0], m[2][1], m[2][2])));
}

// Inverse transpose of the linear part up to a positive factor: the cofactor matrix, with the
// determinant's sign so that a mirror keeps the front side in front.
std::array<Vec3d, 3> normal_rows(const Mat44d& m) {
  const Vec3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]),
      z(m[2][0], m[2][1], m[2][2]);
  std::array<Vec3d, 3> rows = {y.cross(z), z.cross(x), x.cross(y)};
  // Scaled to a largest entry of 1: cofactors of a 1e-6 transform are 1e-12.
  double largest = 0;
  for (const Vec3d& r : rows) {
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(r[c]));
  }
  const double factor = (determinant3(m) < 0 ? -1.0 : 1.0) / largest;
  for (Vec3d& r : rows) r *= factor;
  return rows;
}

template <typename Vector>
uint64_t vector_bytes(const Vector& v) {
  return v.capacity() * sizeof(*v.begin());
}

std::string megabytes(uint64_t bytes) { return fmt::format("{:.1f} MiB", double(bytes) / 1048576); }

}  // namespace

class SceneBuilder {
 public:
  SceneBuilder(SceneDescription description, const SceneBuildOptions& options)
      : description_(std::move(description)), options_(options), scene_(new Scene()) {}

  std::unique_ptr<Scene> build() {
    require_features(description_);
    choose_space();
    scene_->materials_ = std::make_unique<MaterialSet>(description_, worn_materials());
    place_meshes();
    count_instances();
    if (options_.bvh) build_geometry();
    build_lights();
    account();
    return std::move(scene_);
  }

 private:
  void choose_space();
  std::vector<bool> worn_materials() const;
  void place_meshes();
  void bake(MeshDescription& source, const InstanceDescription& placed, Mesh& mesh);
  void adopt(MeshDescription& source, Mesh& mesh);
  void count_instances();
  void build_geometry();
  void build_lights();
  void collect_emitters(std::vector<EmissiveTriangle>& triangles);
  PointLight place_light(const PunctualLightDescription& source) const;
  void account();
  Affine to_internal(const Mat44d& to_world) const;

  SceneDescription description_;
  SceneBuildOptions options_;
  std::unique_ptr<Scene> scene_;
  std::vector<uint32_t> uses_;  // instances per mesh
};

void SceneBuilder::choose_space() {
  const WorldBounds bounds = world_bounds(description_);
  const double radius = bounds.radius();
  if (!std::isfinite(radius)) {
    throw InputError(description_.file, "the scene's extent is not finite");
  }
  const Vec3d center = bounds.empty() ? Vec3d(0.0) : bounds.center();
  // Nearer than twice its size the origin costs at most a bit of precision: leave it, so that an
  // ordinary scene keeps its very coordinates.
  if (center.length() > 2.0 * radius && !bounds.empty()) scene_->origin_ = center;
  // Extremes of size lose squared lengths to underflow or overflow. A power of two is exact.
  if (radius > 0 && (radius < 1e-3 || radius > 1e5)) {
    scene_->scale_ = std::exp2(-std::round(std::log2(radius)));
  }
  scene_->radius_ = float(radius * scene_->scale_);
  if (scene_->origin_ != Vec3d(0.0)) {
    scene_->features_.push_back(
        fmt::format("rebasing (origin {:.6g}, {:.6g}, {:.6g})", center.x, center.y, center.z));
  }
  if (scene_->scale_ != 1.0) {
    scene_->features_.push_back(fmt::format("rescaling (x {:.6g})", scene_->scale_));
  }
}

// Which materials some placed triangle has.
std::vector<bool> SceneBuilder::worn_materials() const {
  std::vector<bool> worn(description_.materials.size(), false);
  for (const InstanceDescription& placed : description_.instances) {
    const MeshDescription& mesh = description_.meshes[size_t(placed.mesh)];
    if (mesh.material >= 0 && !mesh.triangles.empty()) worn[size_t(mesh.material)] = true;
  }
  return worn;
}

Affine SceneBuilder::to_internal(const Mat44d& m) const {
  const double s = scene_->scale_;
  const auto row = [&](int i) { return to_float(Vec3d(m[i][0], m[i][1], m[i][2]) * s); };
  const Vec3d t = (Vec3d(m[3][0], m[3][1], m[3][2]) - scene_->origin_) * s;
  return {row(0), row(1), row(2), to_float(t)};
}

void SceneBuilder::adopt(MeshDescription& source, Mesh& mesh) {
  mesh.material = &(*scene_->materials_)[source.material];
  // What the material does not read is neither kept nor interpolated at every hit.
  if (!mesh.material->has_normal_map()) source.tangents = {};
  if (!options_.unread_uv) {
    const uint32_t read = mesh.material->uv_mask();
    for (size_t set = 0; set < source.uv_sets.size(); ++set) {
      if (set >= kMaxUvSets || (read >> set & 1u) == 0) source.uv_sets[set] = {};
    }
    if (read == 0) source.uv_sets = {};
  }
  mesh.has_attributes =
      mesh.material->reads_attributes(!source.colors.empty()) || !source.uv_sets.empty();
  mesh.positions = std::move(source.positions);
  // Embree reads 16 bytes at the last vertex. Growing by itself, the vector would double.
  mesh.positions.reserve(mesh.positions.size() + 1);
  mesh.positions.emplace_back(0.0f);
  mesh.triangles = std::move(source.triangles);
  mesh.normals = std::move(source.normals);
  mesh.tangents = std::move(source.tangents);
  mesh.uv_sets = std::move(source.uv_sets);
  mesh.colors = std::move(source.colors);
}

void SceneBuilder::bake(MeshDescription& source, const InstanceDescription& placed, Mesh& mesh) {
  adopt(source, mesh);
  const Mat44d& m = placed.to_world;
  const bool mirrored = determinant3(m) < 0;
  for (size_t i = 0; i + 1 < mesh.positions.size(); ++i) {
    const Vec3d world = transform_point(m, to_double(mesh.positions[i]));
    mesh.positions[i] = to_float((world - scene_->origin_) * scene_->scale_);
  }
  if (mirrored) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  const std::array<Vec3d, 3> rows = normal_rows(m);
  for (Vec3f& n : mesh.normals) {
    n = normalize_or(
        to_float(rows[0] * double(n.x) + rows[1] * double(n.y) + rows[2] * double(n.z)),
        Vec3f(0.0f));
  }
  for (Vec4f& t : mesh.tangents) {
    const Vec3f direction =
        normalize_or(to_float(transform_vector(m, Vec3d(t.x, t.y, t.z))), Vec3f(0.0f));
    t = Vec4f(direction.x, direction.y, direction.z, mirrored ? -t.w : t.w);
  }
}

void SceneBuilder::place_meshes() {
  Scene& scene = *scene_;
  uses_.assign(description_.meshes.size(), 0);
  for (const InstanceDescription& placed : description_.instances) uses_[size_t(placed.mesh)]++;
  scene.meshes_.resize(description_.meshes.size());
  scene.instances_.resize(description_.instances.size());
  for (size_t i = 0; i < scene.instances_.size(); ++i) {
    const InstanceDescription& placed = description_.instances[i];
    const auto mesh_index = size_t(placed.mesh);
    Mesh& mesh = scene.meshes_[mesh_index];
    MeshDescription& source = description_.meshes[mesh_index];
    Instance& instance = scene.instances_[i];
    instance.mesh = uint32_t(placed.mesh);
    if (uses_[mesh_index] == 1) {
      bake(source, placed, mesh);
    } else {
      if (mesh.triangles.empty()) adopt(source, mesh);
      instance.transformed = true;
      instance.mirrored = determinant3(placed.to_world) < 0;
      instance.to_internal = to_internal(placed.to_world);
      const std::array<Vec3d, 3> rows = normal_rows(placed.to_world);
      instance.normal_transform = {to_float(rows[0]), to_float(rows[1]), to_float(rows[2]),
                                   Vec3f(0.0f)};
    }
    scene.triangle_count_ += mesh.triangles.size();
    mesh.material_index =
        uint32_t(source.material < 0 ? int(description_.materials.size()) : source.material);
    mesh.cull_backfaces = !options_.show_backfaces && !mesh.material->double_sided() &&
                          !mesh.material->has_transmission();
    mesh.has_coverage = mesh.material->has_alpha(!mesh.colors.empty());
    if (mesh.has_coverage) scene.has_coverage_ = true;
    if (mesh.material->has_transmission()) scene.has_transmission_ = true;
  }
}

void SceneBuilder::count_instances() {
  const auto instanced = std::ranges::count_if(scene_->instances_, [&](const Instance& instance) {
    return instance.transformed && !scene_->meshes_[instance.mesh].triangles.empty();
  });
  if (instanced > 0) {
    scene_->features_.push_back(fmt::format("instancing ({} instances)", instanced));
  }
}

void SceneBuilder::build_geometry() {
  Scene& scene = *scene_;
  scene.geometry_ = std::make_unique<scene_detail::Geometry>();
  scene_detail::Geometry& geometry = *scene.geometry_;
  std::vector<RTCScene> mesh_scenes(scene.meshes_.size(), nullptr);
  for (uint32_t i = 0; i < scene.instances_.size(); ++i) {
    const Instance& instance = scene.instances_[i];
    const Mesh& mesh = scene.meshes_[instance.mesh];
    if (mesh.triangles.empty()) continue;
    if (!instance.transformed) {
      geometry.add_mesh(mesh, i);
    } else {
      RTCScene& mesh_scene = mesh_scenes[instance.mesh];
      if (!mesh_scene) mesh_scene = geometry.add_mesh_scene(mesh);
      geometry.add_instance(mesh_scene, instance.to_internal, i);
    }
  }
  geometry.commit();
}

void SceneBuilder::collect_emitters(std::vector<EmissiveTriangle>& triangles) {
  Scene& scene = *scene_;
  size_t total = 0;
  for (const Instance& instance : scene.instances_) {
    const Mesh& mesh = scene.meshes_[instance.mesh];
    if (mesh.material->is_emissive()) total += mesh.triangles.size();
  }
  // The light BVH numbers its nodes with 30 bits.
  if (total >= size_t(1) << 30) {
    throw InputError(description_.file, "more than 2^30 emissive triangles");
  }
  triangles.reserve(total);
  for (uint32_t i = 0; i < scene.instances_.size(); ++i) {
    Instance& instance = scene.instances_[i];
    const Mesh& mesh = scene.meshes_[instance.mesh];
    const Material& material = *mesh.material;
    if (!material.is_emissive()) continue;
    instance.first_emitter = uint32_t(triangles.size());
    for (uint32_t p = 0; p < mesh.triangles.size(); ++p) {
      Vec3f corners[3];
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t vertex = mesh.triangles[p][c];
        corners[c] = mesh.positions[vertex];
        if (instance.transformed) {
          const Affine& m = instance.to_internal;
          const Vec3d q = to_double(corners[c]);
          corners[c] = to_float(to_double(m.x) * q.x + to_double(m.y) * q.y + to_double(m.z) * q.z +
                                to_double(m.translation));
        }
      }
      EmissiveTriangle t;
      t.p0 = corners[0];
      t.p1 = corners[1];
      t.p2 = corners[2];
      if (instance.mirrored) std::swap(t.p1, t.p2);
      using scene_detail::interpolate_attributes;
      t.mean_radiance = material.mean_emission(interpolate_attributes(mesh, p, 0.0f, 0.0f),
                                               interpolate_attributes(mesh, p, 1.0f, 0.0f),
                                               interpolate_attributes(mesh, p, 0.0f, 1.0f));
      t.two_sided =
          material.double_sided() || material.has_transmission() || options_.show_backfaces;
      t.instance = i;
      t.primitive = p;
      triangles.push_back(t);
    }
  }
}

PointLight SceneBuilder::place_light(const PunctualLightDescription& source) const {
  PointLight light;
  const Mat44d& m = source.to_world;
  const Vec3d position(m[3][0], m[3][1], m[3][2]);
  light.position = to_float((position - scene_->origin_) * scene_->scale_);
  light.direction = normalize_or(to_float(-Vec3d(m[2][0], m[2][1], m[2][2])), Vec3f(0, 0, -1));
  light.intensity = source.intensity;
  if (source.type == PunctualType::kDirectional) {
    light.type = PointLightType::kDirectional;
  } else {
    light.type =
        source.type == PunctualType::kSpot ? PointLightType::kSpot : PointLightType::kPoint;
    // Intensity over internal distance squared must be intensity over world distance squared.
    light.intensity *= float(scene_->scale_ * scene_->scale_);
    light.cos_inner = std::cos(source.inner_cone);
    light.cos_outer = std::cos(source.outer_cone);
  }
  return light;
}

void SceneBuilder::build_lights() {
  Scene& scene = *scene_;
  std::vector<EmissiveTriangle> triangles;
  collect_emitters(triangles);
  std::vector<PointLight> points;
  points.reserve(description_.lights.size());
  for (const PunctualLightDescription& light : description_.lights) {
    if (!is_black(light.intensity)) points.push_back(place_light(light));
  }
  const bool anything_lit =
      std::any_of(scene.meshes_.begin(), scene.meshes_.end(),
                  [](const Mesh& m) { return m.material && !m.material->unlit(); });
  if (triangles.empty() && points.empty() && !description_.environment && anything_lit) {
    log_warning(
        "the scene has no light; using a plain white environment (--env FILE gives another)");
    description_.environment = EnvironmentDescription{};
  }
  std::shared_ptr<const EnvironmentLight> environment;
  if (description_.environment) {
    const EnvironmentDescription& e = *description_.environment;
    environment = e.image
                      ? std::make_shared<EnvironmentLight>(e.image, e.strength, e.rotation_degrees)
                      : std::make_shared<EnvironmentLight>(e.constant * e.strength);
    scene.features_.push_back(
        e.image ? fmt::format("environment map ({} x {})", e.image->width, e.image->height)
                : std::string("constant environment"));
  }
  scene.lights_ = std::make_unique<LightSampler>(std::move(triangles), std::move(points),
                                                 std::move(environment), options_.lights);
  if (!scene.lights_->empty()) scene.features_.push_back("lights: " + scene.lights_->describe());
  if (options_.bvh) {  // it is what finds them
    scene.flush_ = scene_detail::FlushEmitters::find(scene.meshes_, scene.instances_,
                                                     *scene.geometry_, scene.lights_->triangles());
    scene.geometry_->check();
  }
  if (scene.flush_) {
    scene.features_.push_back(
        fmt::format("flush emitters ({} triangles lie in another surface)", scene.flush_->size()));
  }
}

void SceneBuilder::account() {
  Scene& scene = *scene_;
  SceneMemory& memory = scene.memory_;
  bool culls = false, masks = false, blends = false;
  memory.geometry_bytes += vector_bytes(scene.meshes_);
  for (const Mesh& mesh : scene.meshes_) {
    memory.geometry_bytes += vector_bytes(mesh.positions) + vector_bytes(mesh.triangles) +
                             vector_bytes(mesh.normals) + vector_bytes(mesh.tangents) +
                             vector_bytes(mesh.colors) + vector_bytes(mesh.uv_sets);
    for (const auto& set : mesh.uv_sets) memory.geometry_bytes += vector_bytes(set);
    if (mesh.triangles.empty()) continue;
    culls = culls || mesh.cull_backfaces;
    if (!mesh.has_coverage) continue;
    (mesh.material->alpha_mode() == AlphaMode::kMask ? masks : blends) = true;
  }
  memory.geometry_bytes += vector_bytes(scene.instances_);
  if (scene.geometry_) {
    memory.geometry_bytes += scene.geometry_->record_bytes();
    memory.bvh_bytes = scene.geometry_->embree_bytes();
  }
  memory.texture_bytes = scene.materials_->bytes();
  if (const EnvironmentLight* environment = scene.lights_->environment()) {
    memory.texture_bytes += environment->bytes();
  }
  memory.geometry_bytes += scene.lights_->bytes();
  if (culls) scene.features_.push_back("back-face culling (single-sided materials)");
  if (masks || blends) {
    scene.features_.push_back(std::string("alpha coverage (") + (masks ? "mask" : "") +
                              (masks && blends ? ", " : "") + (blends ? "blend)" : ")"));
  }
  for (const std::string& feature : scene.materials_->features()) {
    scene.features_.push_back(feature);
  }
  scene.features_.push_back(
      fmt::format("BVH, {} triangles placed{}", scene.triangle_count_,
                  options_.bvh ? fmt::format(" ({})", megabytes(memory.bvh_bytes)) : ""));
}

std::unique_ptr<Scene> build_scene(SceneDescription description, const SceneBuildOptions& options) {
  return SceneBuilder(std::move(description), options).build();
}

}  // namespace emberline
