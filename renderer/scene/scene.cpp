#include "renderer/scene/scene.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "renderer/scene/flush_emitters.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/solids.h"

namespace emberline {

using scene_detail::Affine;
using scene_detail::Instance;
using scene_detail::Mesh;

namespace {

// Relative error bound of a computed surface point and of Embree's plane test: 4 ulp of the largest
// coordinate. In tests with scenes of 1e-6 to 1e6 units, some far from the origin, this bound
// avoids leaks and self-intersections where fixed epsilons fail; see README.md, "Ray offsets".
constexpr float kOffsetUlps = 4.0f * 0x1p-23f;

[[gnu::always_inline]] inline Vec3f transform_vector(const Affine& m, const Vec3f& v) {
  return fma(m.z, v.z, fma(m.y, v.y, m.x * v.x));
}

// Returns |M| |p| + |t|, the magnitude of the summed terms. Rounding errors are proportional to it.
float transformed_magnitude(const Affine& m, const Vec3f& p) {
  Vec3f sum;
  for (int c = 0; c < 3; ++c) {
    sum[c] = std::abs(m.x[c] * p.x) + std::abs(m.y[c] * p.y) + std::abs(m.z[c] * p.z) +
             std::abs(m.translation[c]);
  }
  return max_component(sum);
}

// Returns a normal for a triangle that became degenerate when it was placed and rounded. Rays may
// still hit it, because Embree rounds differently. Any normal perpendicular to its longer edge will
// do.
Vec3d degenerate_normal(const Vec3d& e1, const Vec3d& e2) {
  const Vec3d e = e1.length2() > e2.length2() ? e1 : e2;
  const Vec3d n = std::abs(e.x) < std::abs(e.y) ? Vec3d(0, -e.z, e.y) : Vec3d(e.z, 0, -e.x);
  return n.length2() > 0 ? n : Vec3d(0, 0, 1);
}

[[maybe_unused]] bool is_finite_ray(const Vec3f& origin, const Vec3f& direction) {
  return is_finite(origin) && is_finite(direction);
}

}  // namespace

namespace scene_detail {

RTCRay make_ray(const Vec3f& origin, const Vec3f& direction, float t_max, float time) {
  return {.org_x = origin.x,
          .org_y = origin.y,
          .org_z = origin.z,
          .tnear = 0.0f,
          .dir_x = direction.x,
          .dir_y = direction.y,
          .dir_z = direction.z,
          .time = time,
          .tfar = t_max,
          .mask = 0xffffffffu,
          .id = 0,
          .flags = 0};
}

RTCRayHit make_ray_hit(const RTCRay& ray) {
  RTCRayHit result;
  result.ray = ray;
  result.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  result.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return result;
}

[[gnu::noinline, gnu::cold]] std::array<Vec3d, 3> moved_corners(const Mesh& mesh,
                                                                uint32_t primitive, float time) {
  const TimeSegment at(time, mesh.motion.size() + 1);
  std::array<Vec3d, 3> p;
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = mesh.triangles[primitive][c];
    const Vec3d before = to_double(positions_at(mesh, at.step)[v]);
    p[c] = before + (to_double(positions_at(mesh, at.step + 1)[v]) - before) * double(at.fraction);
  }
  return p;
}

// The error of Embree's plane depends on the triangle's largest coordinate, not on the hit point.
[[gnu::always_inline]] inline float largest_coordinate(const std::vector<Vec3f>& positions,
                                                       const std::array<uint32_t, 3>& triangle) {
  float magnitude = 0.0f;
  for (const uint32_t i : triangle) {
    magnitude = std::max(magnitude, max_abs_component(positions[i]));
  }
  return magnitude;
}

// Doubles the error, because Embree also rounds when it interpolates between two steps.
[[gnu::noinline, gnu::cold]] static float moved_plane_error(const Mesh& mesh,
                                                            const Instance& instance,
                                                            uint32_t primitive, float time) {
  const size_t step = TimeSegment(time, mesh.motion.size() + 1).step;
  const std::array<uint32_t, 3>& triangle = mesh.triangles[primitive];
  return 2.0f * plane_error(std::max(largest_coordinate(positions_at(mesh, step), triangle),
                                     largest_coordinate(positions_at(mesh, step + 1), triangle)),
                            instance);
}

float plane_error(const Mesh& mesh, const Instance& instance, uint32_t primitive, float time) {
  if (!mesh.motion.empty()) [[unlikely]]
    return moved_plane_error(mesh, instance, primitive, time);
  return plane_error(largest_coordinate(mesh.positions, mesh.triangles[primitive]), instance);
}

float plane_error(float largest, const Instance& instance) {
  float magnitude = largest;
  if (instance.transformed) {
    magnitude = transformed_magnitude(instance.to_internal, Vec3f(magnitude));
  }
  return kOffsetUlps * magnitude;
}

}  // namespace scene_detail

using scene_detail::corners_at;
using scene_detail::interpolate_vertices;
using scene_detail::make_ray;
using scene_detail::make_ray_hit;
using scene_detail::plane_error;
using scene_detail::TimeSegment;
using scene_detail::transform_point;

uint32_t Scene::bvh_builds() const { return geometry_ ? geometry_->device()->bvh_builds : 0; }

std::vector<uint64_t> Scene::mesh_keys() const {
  std::vector<uint64_t> keys;
  for (const Mesh& mesh : meshes_) {
    if (mesh.key != 0) keys.push_back(mesh.key);
  }
  std::ranges::sort(keys);
  return keys;
}

Scene::Scene() = default;
Scene::~Scene() = default;

bool Scene::intersect(const Ray& ray, CoverageKey coverage_key, SurfaceHit* hit) const {
  // Embree's traversal time is undefined for rays that are not finite.
  assert(is_finite_ray(ray.origin, ray.direction));
  RTCRayHit ray_hit = make_ray_hit(make_ray(ray.origin, ray.direction, ray.t_max, ray.time));
  embree::RayContext context;
  embree::init_context(context, coverage_key);
  embree::intersect(geometry_->top(), context, ray_hit);
  if (ray_hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->t = ray_hit.ray.tfar;
  hit->u = ray_hit.hit.u;
  hit->v = ray_hit.hit.v;
  // For geometry outside an Embree instance and for the static group, instID is not the index of a
  // scene instance, but geomID is.
  hit->instance =
      ray_hit.hit.instID[0] < instances_.size() ? ray_hit.hit.instID[0] : ray_hit.hit.geomID;
  hit->primitive = ray_hit.hit.primID;
  if (flush_) resolve_flush_emitter(ray, coverage_key, hit);
  return true;
}

namespace {

struct FaceCollector {
  embree::RayContext ray;  // must be first, so that the filter can cast back
  std::span<CrossedFace> out;
  size_t count;
  size_t instances;  // number of instances in the scene

  // Records every face and continues the ray.
  static void collect(const RTCFilterFunctionNArguments* arguments) {
    auto& self = *reinterpret_cast<FaceCollector*>(
        reinterpret_cast<embree::RayContext*>(arguments->context));
    const unsigned n = arguments->N;
    for (unsigned i = 0; i < n; ++i) {
      if (arguments->valid[i] != -1) continue;
      arguments->valid[i] = 0;
      if (self.count == self.out.size()) continue;
      RTCHitN* const hit = arguments->hit;
      RTCRayN* const ray = arguments->ray;
      const uint32_t placed = RTCHitN_instID(hit, n, i, 0);
      const Vec3f normal(RTCHitN_Ng_x(hit, n, i), RTCHitN_Ng_y(hit, n, i), RTCHitN_Ng_z(hit, n, i));
      const Vec3f direction(RTCRayN_dir_x(ray, n, i), RTCRayN_dir_y(ray, n, i),
                            RTCRayN_dir_z(ray, n, i));
      self.out[self.count++] = {
          {RTCRayN_tfar(ray, n, i), RTCHitN_u(hit, n, i), RTCHitN_v(hit, n, i),
           placed < self.instances ? placed : RTCHitN_geomID(hit, n, i), RTCHitN_primID(hit, n, i)},
          dot(normal, direction) > 0.0f};
    }
  }
};

}  // namespace

size_t Scene::faces_along(const Vec3f& from, const Vec3f& direction, float length, float time,
                          CoverageKey coverage_key, std::span<CrossedFace> out) const {
  assert(is_finite_ray(from, direction));
  RTCRayHit ray_hit = make_ray_hit(make_ray(from, direction, length, time));
  FaceCollector collector{{}, out, 0, instances_.size()};
  embree::init_context(collector.ray, coverage_key);
  embree::intersect(geometry_->top(), collector.ray, ray_hit, FaceCollector::collect);
  return collector.count;
}

bool Scene::moves(uint32_t instance) const {
  const Instance& placed = instances_[instance];
  return scene_detail::moves(meshes_[placed.mesh], placed);
}

bool Scene::has_faces_near(uint32_t index, const Imath::Box3f& box) const {
  const Instance& instance = instances_[index];
  const Mesh& mesh = meshes_[instance.mesh];
  for (uint32_t p = 0; p < mesh.triangles.size(); ++p) {
    Imath::Box3f face;
    for (const Vec3d& corner : scene_detail::placed_corners(mesh, instance, p)) {
      face.extendBy(to_float(corner));
    }
    if (face.intersects(box)) return true;
  }
  return false;
}

static float transmittance_along(RTCScene scene, RTCRay ray, CoverageKey coverage_key) {
  embree::Thickness thickness(coverage_key);
  embree::RayContext context;
  embree::init_context(context, coverage_key);
  context.thickness = &thickness;
  embree::occluded(scene, context, ray);
  return ray.tfar >= 0.0f ? thickness.transmittance() : 0.0f;
}

float Scene::transmittance(const Vec3f& from, const Vec3f& to, float time,
                           CoverageKey coverage_key) const {
  if (from == to) return 1.0f;
  // With an unnormalised direction, t = 1 is exactly the far point, without a division.
  assert(is_finite_ray(from, to));
  return transmittance_along(geometry_->top(), make_ray(from, to - from, 1.0f, time), coverage_key);
}

float Scene::transmittance_to_infinity(const Vec3f& from, const Vec3f& direction, float time,
                                       CoverageKey coverage_key) const {
  assert(is_finite_ray(from, direction));
  return transmittance_along(geometry_->top(), make_ray(from, direction, kInfinity, time),
                             coverage_key);
}

namespace {

// Interpolates vertex values of a deforming mesh at (u, v) of the triangle.
template <class T>
[[gnu::noinline, gnu::cold]] T interpolate_moved(const Mesh& mesh,
                                                 std::vector<T> MeshArrays::*at_open,
                                                 std::vector<T> MeshStep::*moved,
                                                 const SurfaceHit& hit, float time) {
  const std::array<uint32_t, 3>& index = mesh.triangles[hit.primitive];
  const TimeSegment at(time, mesh.motion.size() + 1);
  const T before = interpolate_vertices(
      at.step == 0 ? mesh.*at_open : mesh.motion[at.step - 1].*moved, index, hit.u, hit.v);
  const T after = interpolate_vertices(mesh.motion[at.step].*moved, index, hit.u, hit.v);
  return before + (after - before) * at.fraction;
}

template <class T>
[[gnu::always_inline]] inline T interpolate_at(const Mesh& mesh,
                                               std::vector<T> MeshArrays::*at_open,
                                               std::vector<T> MeshStep::*moved,
                                               const SurfaceHit& hit, float time) {
  if (!mesh.motion.empty()) [[unlikely]]
    return interpolate_moved(mesh, at_open, moved, hit, time);
  return interpolate_vertices(mesh.*at_open, mesh.triangles[hit.primitive], hit.u, hit.v);
}

}  // namespace

// Interpolates the attributes that are needed only for textures, vertex colours and coverage.
void Scene::interpolate(const Mesh& mesh, const Instance& instance, const SurfaceHit& hit,
                        float time, SurfaceInteraction& s) const {
  s.attributes = scene_detail::interpolate_attributes(mesh, hit.primitive, hit.u, hit.v);
  s.tangent = Vec4f(0.0f);
  if (mesh.tangents.empty()) return;
  const std::array<uint32_t, 3>& index = mesh.triangles[hit.primitive];
  const Vec4f t = interpolate_at(mesh, &MeshArrays::tangents, &MeshStep::tangents, hit, time);
  Vec3f direction(t.x, t.y, t.z);
  float handedness = mesh.tangents[index[0]].w;
  if (instance.transformed) {
    direction = transform_vector(instance.to_internal, direction);
    // A mirror reverses N x T.
    if (instance.mirrored) handedness = -handedness;
  }
  direction = normalize_or(direction, Vec3f(0.0f));
  s.tangent = Vec4f(direction.x, direction.y, direction.z, handedness);
}

// The slow path, for moving instances. It is kept out of line.
[[gnu::noinline, gnu::cold]] const Instance& Scene::moved_instance(const Instance& instance,
                                                                   float time,
                                                                   Instance* moved) const {
  *moved = instance;
  const Affine m = geometry_->transform_at(instance.moving_index, time);
  moved->to_internal = m;
  const Vec3d x = to_double(m.x), y = to_double(m.y), z = to_double(m.z);
  const Vec3d rows[3] = {cross(y, z), cross(z, x), cross(x, y)};
  const double volume = dot(x, rows[0]);
  moved->mirrored = volume < 0;
  double largest = 0;
  for (const Vec3d& row : rows) {
    largest = std::max({largest, std::abs(row.x), std::abs(row.y), std::abs(row.z)});
  }
  const double factor = largest > 0 ? (volume < 0 ? -1.0 : 1.0) / largest : 0.0;
  moved->normal_transform = {to_float(rows[0] * factor), to_float(rows[1] * factor),
                             to_float(rows[2] * factor), Vec3f(0.0f)};
  return *moved;
}

void Scene::prefetch_triangle(const SurfaceHit& hit) const {
  __builtin_prefetch(&meshes_[instances_[hit.instance].mesh].triangles[hit.primitive]);
}

void Scene::prefetch_vertices(const SurfaceHit& hit) const {
  const Mesh& mesh = meshes_[instances_[hit.instance].mesh];
  for (const uint32_t vertex : mesh.triangles[hit.primitive]) {
    __builtin_prefetch(&mesh.positions[vertex]);
    if (!mesh.normals.empty()) __builtin_prefetch(&mesh.normals[vertex]);
    if (!mesh.has_attributes) continue;
    if (!mesh.tangents.empty()) __builtin_prefetch(&mesh.tangents[vertex]);
    if (!mesh.uv_sets.empty() && !mesh.uv_sets[0].empty()) {
      __builtin_prefetch(&mesh.uv_sets[0][vertex]);
    }
  }
}

void Scene::interaction(const SurfaceHit& hit, float time, SurfaceInteraction* out) const {
  Instance moved;
  const Instance& instance = instance_at(hit.instance, time, &moved);
  const Mesh& mesh = meshes_[instance.mesh];
  const auto [v0, v1, v2] = corners_at(mesh, hit.primitive, time);

  SurfaceInteraction& s = *out;
  // The position is computed in double and rounded once. Its error is about a tenth of the error of
  // origin + t * d.
  const Vec3d e1 = v1 - v0;
  const Vec3d e2 = v2 - v0;
  Vec3d position = fma(e2, double(hit.v), fma(e1, double(hit.u), v0));
  Vec3d normal = cross(e1, e2);
  if (instance.transformed) {
    const Affine& m = instance.to_internal;
    position = transform_point(m, position);
    const Affine& nt = instance.normal_transform;
    normal =
        fma(to_double(nt.z), normal.z, fma(to_double(nt.y), normal.y, to_double(nt.x) * normal.x));
  }
  s.position = to_float(position);
  s.offset = offset_of(instance, hit.instance, hit.primitive, time);
  double length2 = dot(normal, normal);
  if (!(length2 > 0)) [[unlikely]] {
    normal = degenerate_normal(e1, e2);
    length2 = dot(normal, normal);
  }
  s.geometric_normal = to_float(normal * (1.0 / std::sqrt(length2)));

  s.shading_normal = s.geometric_normal;
  if (!mesh.normals.empty()) {
    Vec3f n = interpolate_at(mesh, &MeshArrays::normals, &MeshStep::normals, hit, time);
    if (instance.transformed) n = transform_vector(instance.normal_transform, n);
    s.shading_normal = normalize_or(n, s.geometric_normal);
  }
  if (mesh.has_attributes) interpolate(mesh, instance, hit, time, s);
  s.instance = hit.instance;
  s.material = mesh.material;
  s.material_index = mesh.material_index;
}

namespace {

Vec3d interpolate_position(const std::array<Vec3d, 3>& p, const SurfaceHit& hit) {
  return fma(p[2] - p[0], double(hit.v), fma(p[1] - p[0], double(hit.u), p[0]));
}

}  // namespace

Vec3d Scene::position_at(const SurfaceHit& hit, float time) const {
  Instance moved;
  const Instance& instance = instance_at(hit.instance, time, &moved);
  return interpolate_position(
      scene_detail::placed_corners(meshes_[instance.mesh], instance, hit.primitive, time), hit);
}

Vec3d Scene::next_frame_position(const scene_detail::NextFramePlacement& next_frame,
                                 const SurfaceHit& hit) const {
  const Mesh& mesh = meshes_[instances_[hit.instance].mesh];
  const std::vector<Vec3f>& positions = mesh.next_frame.empty() ? mesh.positions : mesh.next_frame;
  std::array<Vec3d, 3> corners;
  for (size_t c = 0; c < 3; ++c)
    corners[c] = to_double(positions[mesh.triangles[hit.primitive][c]]);
  return emberline::transform_point(next_frame.to_internal, interpolate_position(corners, hit));
}

Scene::Motion Scene::motion_of(const SurfaceHit& hit) const {
  const Vec3d from = position_at(hit, 0.0f);
  if (moves_) return {from, position_at(hit, 1.0f)};
  const auto next_frame = std::ranges::lower_bound(next_frame_, hit.instance, {},
                                                   &scene_detail::NextFramePlacement::instance);
  if (next_frame == next_frame_.end() || next_frame->instance != hit.instance) return {from, from};
  return {from, next_frame_position(*next_frame, hit)};
}

bool Scene::has_uv(uint32_t instance) const {
  const Mesh& mesh = meshes_[instances_[instance].mesh];
  return !mesh.uv_sets.empty() && !mesh.uv_sets[0].empty();
}

SurfaceAttributes Scene::emitter_attributes(const EmissiveTriangle& triangle, float time,
                                            const Vec2f& barycentric) const {
  Instance moved;
  const Instance& instance = instance_at(triangle.instance, time, &moved);
  if (!meshes_[instance.mesh].has_attributes) return {};
  // An emitter of a mirrored instance lists its corners in reverse order.
  const Vec2f b = instance.mirrored ? Vec2f(barycentric.y, barycentric.x) : barycentric;
  return scene_detail::interpolate_attributes(meshes_[instance.mesh], triangle.primitive, b.x, b.y);
}

std::array<Vec3f, 3> Scene::corners(const EmissiveTriangle& triangle, float time) const {
  Instance moved;
  const Instance& instance = instance_at(triangle.instance, time, &moved);
  const std::array<Vec3d, 3> p =
      scene_detail::placed_corners(meshes_[instance.mesh], instance, triangle.primitive, time);
  std::array<Vec3f, 3> corners = {to_float(p[0]), to_float(p[1]), to_float(p[2])};
  if (instance.transformed && instance.mirrored) std::swap(corners[1], corners[2]);
  return corners;
}

// Returns the least common multiple of the numbers of segments of the transform and of the mesh, so
// that no segment boundary of either lies inside one of the resulting segments.
int Scene::segments(const EmissiveTriangle& triangle) const {
  const Instance& instance = instances_[triangle.instance];
  const size_t mesh_steps = std::max(meshes_[instance.mesh].motion.size(), size_t(1));
  const size_t transform_steps =
      instance.moving_index == Instance::kStatic ? 1 : geometry_->steps(instance.moving_index) - 1;
  return int(std::lcm(mesh_steps, transform_steps));
}

bool Scene::visibility(const EmissiveTriangle& triangle, float time) const {
  return visibility_[triangle.instance]->at(time);
}

const Material& Scene::material_of(uint32_t instance) const {
  return *meshes_[instances_[instance].mesh].material;
}

uint32_t Scene::material_index_of(uint32_t instance) const {
  return meshes_[instances_[instance].mesh].material_index;
}

float Scene::offset_of(const Instance& instance, uint32_t index, uint32_t primitive,
                       float time) const {
  const float error = plane_error(meshes_[instance.mesh], instance, primitive, time);
  return flush_ ? std::max(error, flush_->offset(index, primitive)) : error;
}

float Scene::surface_offset(uint32_t index, uint32_t primitive, float time) const {
  Instance moved;
  return offset_of(instance_at(index, time, &moved), index, primitive, time);
}

// Rounding decides which of several coincident surfaces a ray hits. Replaces the hit by one on the
// surface that is in front by the rule in flush_emitters.h.
void Scene::resolve_flush_emitter(const Ray& ray, CoverageKey coverage_key, SurfaceHit* hit) const {
  Instance moved;
  const Instance& instance = instance_at(hit->instance, ray.time, &moved);
  const std::array<Vec3d, 3> corners =
      scene_detail::placed_corners(meshes_[instance.mesh], instance, hit->primitive, ray.time);
  const Vec3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  const auto cosine = float(std::abs(normal.dot(to_double(ray.direction))));
  scene_detail::FlushEmitters::Candidate best{kNoEmitter, hit->t, hit->u, hit->v};
  if (!flush_->find_lowest_emitter(ray, hit->t, cosine, coverage_key, &best)) return;
  const EmissiveTriangle& emitter = lights_->triangles()[best.emitter];
  *hit = {best.t, best.u, best.v, emitter.instance, emitter.primitive};
}

bool Scene::is_behind_flush_emitter(const Vec3f& from, const LightSample& light, float time,
                                    CoverageKey coverage_key) const {
  if (!flush_ || light.kind != LightKind::kTriangle || !flush_->contains(light.index)) return false;
  scene_detail::FlushEmitters::Candidate best{light.index, 1.0f, 0.0f, 0.0f};
  const Ray ray{from, light.position - from, 1.0f, time};
  return flush_->find_lowest_emitter(ray, 1.0f, std::abs(dot(ray.direction, light.emitter_normal)),
                                     coverage_key, &best);
}

}  // namespace emberline
