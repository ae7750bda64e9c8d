#include "renderer/scene/build_scene.h"

#include <algorithm>
#include <cassert>
#include <unordered_map>

#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"
#include "renderer/description/default_light.h"
#include "renderer/description/framing.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/pose_handover.h"
#include "renderer/scene/scene_updater.h"
#include "renderer/scene/solids.h"

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

double determinant3(const Mat44d& m) { return row(m, 0).dot(row(m, 1).cross(row(m, 2))); }

std::array<Vec3d, 3> cofactors(const Mat44d& m) {
  const Vec3d x = row(m, 0), y = row(m, 1), z = row(m, 2);
  return {y.cross(z), z.cross(x), x.cross(y)};
}

double largest_entry(const std::array<Vec3d, 3>& rows) {
  double largest = 0;
  for (const Vec3d& r : rows) {
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(r[c]));
  }
  return largest;
}

// Returns the inverse transpose of the linear part, up to a positive factor. This is the cofactor
// matrix times the sign of the determinant. The sign keeps the front side in front under mirroring.
std::array<Vec3d, 3> normal_rows(const Mat44d& m) {
  std::array<Vec3d, 3> rows = cofactors(m);
  // The rows are scaled to a largest entry of 1, since the cofactors of a 1e-6 transform are 1e-12.
  const double factor = (determinant3(m) < 0 ? -1.0 : 1.0) / largest_entry(rows);
  for (Vec3d& r : rows) r *= factor;
  return rows;
}

// Returns an upper bound on the factor by which the inverse of `m` enlarges a vector's largest
// coordinate.
double inverse_growth(const Mat44d& m) {
  return 3.0 * largest_entry(cofactors(m)) / std::abs(determinant3(m));
}

// The parameters of internal space.
struct Space {
  Vec3d origin = Vec3d(0.0);
  double scale = 1.0;
};

Space space_of(const WorldBounds& bounds) {
  Space space;
  const double radius = bounds.radius();
  const Vec3d center = bounds.isEmpty() ? Vec3d(0.0) : bounds.center();
  // Keeping an origin that is at most two radii from the centre costs at most one bit of precision,
  // so ordinary scenes keep their origin and thus their exact coordinates.
  if (center.length() > 2.0 * radius && !bounds.isEmpty()) space.origin = center;
  // Scales extreme scenes, whose squared lengths would underflow or overflow. Scaling by a power of
  // two is exact.
  if (radius > 0 && (radius < 1e-3 || radius > 1e5)) {
    space.scale = std::exp2(-std::round(std::log2(radius)));
  }
  return space;
}

// Returns whether geometry in these bounds can use a space that was made for other bounds, with a
// loss of at most four bits of precision (our choice).
bool is_precise_for(const Space& space, const WorldBounds& bounds) {
  if (bounds.isEmpty()) return true;
  const double radius = bounds.radius(), scaled = radius * space.scale;
  return (bounds.center() - space.origin).length() <= 16.0 * radius && scaled >= 1e-3 &&
         scaled <= 1e5;
}

// Returns whether both instances have the same placement. Call this only for instances without
// motion.
bool has_same_placement(const Instance& a, const Instance& b) {
  if (a.mesh != b.mesh || a.transformed != b.transformed || a.moving_index != b.moving_index)
    return false;
  return !a.transformed || (a.mirrored == b.mirrored && a.to_internal == b.to_internal &&
                            a.normal_transform == b.normal_transform);
}

}  // namespace

class SceneBuilder {
 public:
  SceneBuilder(SceneDescription description, const SceneBuildOptions& options,
               LoadProgress& progress)
      : description_(std::move(description)),
        options_(options),
        progress_(progress),
        scene_(new Scene()) {}

  std::unique_ptr<Scene> build() {
    begin();
    place_meshes();
    add_next_frame_placements();
    SceneUpdater updater(*scene_, description_, options_, progress_);
    finish_build(updater, nullptr);
    updater.update_memory_and_features();
    progress_.finish();
    return std::move(scene_);
  }

  bool repose(std::unique_ptr<Scene>& before);

 private:
  void begin();
  void finish_build(SceneUpdater& updater, const Scene* before);
  bool find_reused_meshes(const Scene& before);
  bool has_same_layout(const Scene& before) const;
  void choose_space();
  void place_meshes();
  void add_next_frame_placements();
  bool is_baked(const InstanceDescription& placed) const;
  void limit_origins(const Mat44d& to_world, const std::string& mesh);
  void bake(MeshDescription& source, const InstanceDescription& placed, Mesh& mesh);
  void move_arrays(MeshDescription& source, Mesh& mesh);
  void drop_unread_attributes();
  void build_geometry(const Scene* before);
  bool is_static(const Instance& instance) const;
  Mat44d to_internal(const Mat44d& to_world) const;
  void place(const InstanceDescription& placed, Instance& instance);

  SceneDescription description_;
  SceneBuildOptions options_;
  LoadProgress& progress_;
  std::unique_ptr<Scene> scene_;
  std::vector<uint32_t> instance_counts_;  // instances per mesh
  std::vector<uint32_t>
      previous_mesh_indices_;  // per mesh: its index in the previous scene, or kNone
};

void SceneBuilder::begin() {
  add_default_light(description_);
  progress_.begin(LoadStage::kBvh);
  instance_counts_.assign(description_.meshes.size(), 0);
  for (const InstanceDescription& placed : description_.instances)
    instance_counts_[size_t(placed.mesh)]++;
  choose_space();
  scene_->meshes_.resize(description_.meshes.size());
  scene_->instances_.resize(description_.instances.size());
}

// Runs the steps that follow place_meshes(). These steps may throw.
void SceneBuilder::finish_build(SceneUpdater& updater, const Scene* before) {
  updater.assign_materials();
  if (!options_.editable) drop_unread_attributes();
  updater.find_solids();
  if (options_.bvh) build_geometry(before);
  updater.build_lights();
}

bool SceneBuilder::repose(std::unique_ptr<Scene>& before) {
  begin();
  if (scene_->origin_ != before->origin_ || scene_->scale_ != before->scale_) return false;
  if (!find_reused_meshes(*before)) return false;
  {
    scene_detail::PoseHandover handover(before->meshes_, scene_->meshes_, before->environment_);
    for (uint32_t i = 0; i < previous_mesh_indices_.size(); ++i) {
      if (previous_mesh_indices_[i] != SceneUpdater::kNone)
        handover.move_mesh(previous_mesh_indices_[i], i);
    }
    place_meshes();
    add_next_frame_placements();
    if (!has_same_layout(*before)) {
      SceneUpdater updater(*scene_, description_, options_, progress_);
      updater.reuse_from(*before, previous_mesh_indices_);
      finish_build(updater, before.get());
      handover.commit();
      before.reset();  // free it before memory is counted
      updater.update_memory_and_features();
      before = std::move(scene_);
      progress_.finish();
      return true;
    }
  }
  update_scene(*before, description_, options_);
  progress_.finish();
  return true;
}

// Fills previous_mesh_indices_. Returns whether `before` has all meshes that this pose reuses, in
// the space (internal or object) that this pose needs.
bool SceneBuilder::find_reused_meshes(const Scene& before) {
  std::unordered_map<uint64_t, uint32_t> previous_by_key;
  for (uint32_t i = 0; i < before.meshes_.size(); ++i) {
    if (before.meshes_[i].key != 0) previous_by_key.emplace(before.meshes_[i].key, i);
  }
  previous_mesh_indices_.assign(description_.meshes.size(), SceneUpdater::kNone);
  for (size_t i = 0; i < previous_mesh_indices_.size(); ++i) {
    if (!description_.meshes[i].reused_bounds) continue;
    const auto found = previous_by_key.find(description_.meshes[i].key);
    if (found == previous_by_key.end()) return false;
    previous_mesh_indices_[i] = found->second;
  }
  return std::ranges::all_of(description_.instances, [&](const InstanceDescription& placed) {
    const uint32_t from = previous_mesh_indices_[size_t(placed.mesh)];
    return from == SceneUpdater::kNone || before.meshes_[from].is_baked == is_baked(placed);
  });
}

// Returns whether the scene has exactly the meshes and placements of `before`, and no motion.
bool SceneBuilder::has_same_layout(const Scene& before) const {
  if (previous_mesh_indices_.size() != before.meshes_.size()) return false;
  for (const Scene* scene : {&before, static_cast<const Scene*>(scene_.get())}) {
    if (!scene->visibility_.empty() || !scene->next_frame_.empty()) return false;
  }
  for (uint32_t i = 0; i < previous_mesh_indices_.size(); ++i) {
    if (previous_mesh_indices_[i] != i) return false;
  }
  const auto moves = [](const InstanceDescription& placed) { return !placed.motion.empty(); };
  return std::ranges::none_of(description_.instances, moves) &&
         std::ranges::equal(scene_->instances_, before.instances_, has_same_placement);
}

void SceneBuilder::choose_space() {
  const WorldBounds bounds = world_bounds(description_);
  const double radius = bounds.radius();
  if (!std::isfinite(radius)) {
    throw InputError(
        description_.file,
        "the scene's bounds are not finite; check the transforms and the vertex positions");
  }
  Space space = space_of(bounds);
  // A pose uses the rest pose's space while that space is precise enough, so that all poses share
  // one space.
  if (const auto& rest = description_.rest_bounds;
      rest && is_precise_for(space_of(*rest), bounds)) {
    space = space_of(*rest);
  }
  scene_->origin_ = space.origin;
  scene_->scale_ = space.scale;
  scene_->radius_ = float(radius * scene_->scale_);
}

Mat44d SceneBuilder::to_internal(const Mat44d& to_world) const {
  Mat44d m = to_world;
  for (int c = 0; c < 3; ++c) {
    m[3][c] -= scene_->origin_[c];
    for (int r = 0; r < 4; ++r) m[r][c] *= scene_->scale_;
  }
  return m;
}

void SceneBuilder::move_arrays(MeshDescription& source, Mesh& mesh) {
  const auto pad = [](std::vector<Vec3f>& positions) {
    // Embree reads 16 bytes per vertex, so add a spare vertex. reserve() avoids doubling the
    // capacity.
    positions.reserve(positions.size() + 1);
    positions.emplace_back(0.0f);
  };
  static_cast<MeshArrays&>(mesh) = std::move(source);
  pad(mesh.positions);
  for (MeshStep& step : mesh.motion) pad(step.positions);
}

void SceneBuilder::bake(MeshDescription& source, const InstanceDescription& placed, Mesh& mesh) {
  move_arrays(source, mesh);
  mesh.is_baked = true;
  const Mat44d& m = placed.to_world;
  const bool mirrored = determinant3(m) < 0;
  constexpr size_t kGrain = size_t(1) << 14;  // about 100 microseconds of work
  const auto for_each = [&](size_t count, const auto& change) {
    parallel_each(count, kGrain, [&](size_t i) {
      if (i % 65536 == 0) progress_.check();
      change(i);
    });
  };
  const std::array<Vec3d, 3> rows = normal_rows(m);
  const auto bake_vertices = [&](auto& vertices) {
    for_each(vertices.positions.size() - 1, [&](size_t i) {
      const Vec3d world = transform_point(m, to_double(vertices.positions[i]));
      vertices.positions[i] = to_float((world - scene_->origin_) * scene_->scale_);
    });
    for_each(vertices.normals.size(), [&](size_t i) {
      Vec3f& n = vertices.normals[i];
      n = normalize_or(
          to_float(rows[0] * double(n.x) + rows[1] * double(n.y) + rows[2] * double(n.z)),
          Vec3f(0.0f));
    });
    for_each(vertices.tangents.size(), [&](size_t i) {
      Vec4f& t = vertices.tangents[i];
      const Vec3f direction =
          normalize_or(to_float(transform_vector(m, Vec3d(t.x, t.y, t.z))), Vec3f(0.0f));
      t = Vec4f(direction.x, direction.y, direction.z, mirrored ? -t.w : t.w);
    });
  };
  bake_vertices(mesh);
  for (MeshStep& step : mesh.motion) bake_vertices(step);
  if (mirrored) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
}

// Lowers max_origin_ so that ray origins stay within Embree's range when they are transformed to
// the instance's object space.
void SceneBuilder::limit_origins(const Mat44d& m, const std::string& mesh) {
  const double growth = inverse_growth(m) / scene_->scale_;
  const Vec3d at = (row(m, 3) - scene_->origin_) * scene_->scale_;
  const double distance = max_abs_component(at);
  scene_->max_origin_ = std::min(scene_->max_origin_, kMaxOrigin / growth - distance);
  // Rays must be traceable within the scene and from outside, and Embree must be able to invert the
  // transform in float.
  const double volume = std::abs(determinant3(m)) * std::pow(scene_->scale_, 3.0);
  if (scene_->max_origin_ > 4.0 * double(scene_->radius_) && volume > 1e-36 && volume < 1e36)
    return;
  throw InputError(description_.file,
                   "an instance of mesh '" + mesh +
                       "' has a scale that is too large or too small to trace rays in it");
}

void SceneBuilder::place(const InstanceDescription& placed, Instance& instance) {
  instance.transformed = true;
  instance.mirrored = determinant3(placed.to_world) < 0;
  const Mat44d m = to_internal(placed.to_world);
  instance.to_internal = {to_float(row(m, 0)), to_float(row(m, 1)), to_float(row(m, 2)),
                          to_float(row(m, 3))};
  const std::array<Vec3d, 3> rows = normal_rows(placed.to_world);
  instance.normal_transform = {to_float(rows[0]), to_float(rows[1]), to_float(rows[2]),
                               Vec3f(0.0f)};
  const std::string& mesh = description_.meshes[size_t(placed.mesh)].name;
  limit_origins(placed.to_world, mesh);
  for (const Mat44d& step : placed.motion) limit_origins(step, mesh);
}

// Returns whether the mesh is stored in internal space. This is so if it has a single instance,
// which never moves.
bool SceneBuilder::is_baked(const InstanceDescription& placed) const {
  const auto mesh = size_t(placed.mesh);
  return instance_counts_[mesh] == 1 && placed.motion.empty() &&
         !description_.meshes[mesh].may_move;
}

void SceneBuilder::place_meshes() {
  Scene& scene = *scene_;
  MemoryBudget& budget = *progress_.budget();
  budget.reserve(MemoryPart::kGeometry, bytes_of(description_.meshes.size(), sizeof(Mesh)),
                 description_.file);
  budget.reserve(MemoryPart::kGeometry, bytes_of(description_.instances.size(), sizeof(Instance)),
                 description_.file);
  for (size_t i = 0; i < scene.instances_.size(); ++i) {
    progress_.check();
    const InstanceDescription& placed = description_.instances[i];
    const auto mesh_index = size_t(placed.mesh);
    Mesh& mesh = scene.meshes_[mesh_index];
    MeshDescription& source = description_.meshes[mesh_index];
    Instance& instance = scene.instances_[i];
    instance.mesh = uint32_t(placed.mesh);
    if (placed.visibility) {
      scene.visibility_.resize(scene.instances_.size());
      scene.visibility_[i] = placed.visibility;
      mesh.visibility = &scene.visibility_;
    }
    if (!is_baked(placed)) {
      if (mesh.triangles.empty()) move_arrays(source, mesh);
      place(placed, instance);
    } else if (!source.reused_bounds) {
      bake(source, placed, mesh);
    }
    scene.triangle_count_ += mesh.triangles.size();
  }
}

void SceneBuilder::add_next_frame_placements() {
  auto next = description_.next_frame_instances.begin();
  for (uint32_t i = 0; i < scene_->instances_.size(); ++i) {
    const bool moves = next != description_.next_frame_instances.end() && next->instance == i;
    const Mat44d* next_frame = moves ? &(next++)->to_world : nullptr;
    const Instance& instance = scene_->instances_[i];
    const bool deforms = !scene_->meshes_[instance.mesh].next_frame.empty();
    if (!next_frame && !deforms) continue;
    const Mat44d now = to_internal(description_.instances[i].to_world);
    Mat44d place = next_frame ? to_internal(*next_frame) : now;
    // The mesh is already in internal space, so the transform must map from internal space.
    if (!instance.transformed && !deforms) place = now.inverse() * place;
    progress_.budget()->reserve(MemoryPart::kGeometry, sizeof(scene_detail::NextFramePlacement),
                                description_.file);
    scene_->next_frame_.push_back({i, place});
  }
  scene_->next_frame_.shrink_to_fit();
}

// Frees attributes that the material does not read, so that they are not interpolated at hits.
void SceneBuilder::drop_unread_attributes() {
  for (Mesh& mesh : scene_->meshes_) {
    if (!mesh.material) continue;
    if (!mesh.material->needs_tangents()) {
      // Assigning {} would keep the memory.
      mesh.tangents = std::vector<Vec4f>();
      for (MeshStep& step : mesh.motion) step.tangents = std::vector<Vec4f>();
    }
    if (options_.unread_uv) continue;
    const uint32_t read = mesh.material->uv_mask();
    for (size_t set = 0; set < mesh.uv_sets.size(); ++set) {
      if (set >= kMaxUvSets || (read >> set & 1u) == 0) mesh.uv_sets[set] = std::vector<Vec2f>();
    }
    if (read == 0) mesh.uv_sets = {};
  }
}

bool SceneBuilder::is_static(const Instance& instance) const {
  return !instance.transformed && scene_->meshes_[instance.mesh].key != 0;
}

void SceneBuilder::build_geometry(const Scene* before) {
  using scene_detail::Geometry;
  Scene& scene = *scene_;
  const auto device =
      before ? before->geometry_->device()
             : std::make_shared<scene_detail::EmbreeDevice>(options_.isa.value_or(widest_isa()),
                                                            progress_.budget(), description_.file);
  // Editable scenes also need query filters, because an edit may turn any mesh into a solid.
  device->has_query_filters =
      options_.editable || (scene.solids_ && scene.solids_->touching_faces() > 0);
  scene.geometry_ = std::make_unique<Geometry>(device);
  Geometry& geometry = *scene.geometry_;
  uint64_t items = scene.instances_.size();
  for (const Mesh& mesh : scene.meshes_) items += mesh.bvh ? 0 : mesh.triangles.size();
  progress_.begin(LoadStage::kBvh, items);
  // A separate BVH for the static group is useless if everything is static.
  const bool needs_static_group =
      options_.posable && !std::ranges::all_of(scene.instances_, [&](const Instance& instance) {
        return is_static(instance);
      });
  std::vector<Geometry::StaticInstance> static_instances;
  for (uint32_t i = 0; i < scene.instances_.size(); ++i) {
    Instance& instance = scene.instances_[i];
    Mesh& mesh = scene.meshes_[instance.mesh];
    if (mesh.triangles.empty()) continue;
    if (needs_static_group && is_static(instance)) {
      static_instances.push_back({instance.mesh, i, mesh.key});
      continue;
    }
    if (!instance.transformed) {
      geometry.add_mesh(mesh, i);
      continue;
    }
    // If the mesh now needs another kind of filter, it needs a new BVH. PoseHandover keeps the old
    // one for a rollback.
    if ((mesh.record && mesh.record->tests_visibility) != (mesh.visibility != nullptr)) {
      mesh.bvh.reset();
      mesh.record.reset();
    }
    if (!mesh.bvh) geometry.build_mesh_scene(mesh, progress_);
    const InstanceDescription& placed = description_.instances[i];
    if (placed.motion.empty()) {
      geometry.add_instance(*mesh.bvh, instance.to_internal, i);
      continue;
    }
    std::vector<Mat44d> steps = {to_internal(placed.to_world)};
    for (const Mat44d& step : placed.motion) steps.push_back(to_internal(step));
    instance.moving_index = geometry.add_moving_instance(*mesh.bvh, steps, i);
  }
  geometry.add_static_group(std::move(static_instances), scene.meshes_,
                            before ? before->geometry_.get() : nullptr, progress_);
  geometry.commit(uint32_t(scene.instances_.size()), progress_);
}

std::unique_ptr<Scene> build_scene(SceneDescription description, const SceneBuildOptions& options,
                                   LoadProgress& progress) {
  return SceneBuilder(std::move(description), options, progress).build();
}

void update_scene(Scene& scene, const SceneDescription& description,
                  const SceneBuildOptions& options) {
  assert(options.editable);
  SceneUpdater updater(scene, description, options, LoadProgress::none());
  updater.assign_materials();
  updater.find_solids();
  updater.build_lights();
  updater.update_memory_and_features();
}

bool repose_scene(std::unique_ptr<Scene>& scene, SceneDescription posed,
                  const SceneBuildOptions& options, LoadProgress& progress) {
  assert(options.editable && options.posable);
  return SceneBuilder(std::move(posed), options, progress).repose(scene);
}

}  // namespace emberline
