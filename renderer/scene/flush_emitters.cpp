#include "renderer/scene/flush_emitters.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "renderer/core/parallel.h"

namespace emberline::scene_detail {
namespace {

// From here on triangles are small against what they could lie in, and only their middles are asked
// about: 0.3 us each of one core, a third of what the light BVH takes to build. Chosen by us.
constexpr size_t kManyEmitters = 1 << 16;

uint64_t key_of(uint32_t instance, uint32_t primitive) {
  return uint64_t(instance) << 32 | primitive;
}

struct Corners {
  Vec3d p0, p1, p2;

  Vec3d normal() const {  // unit, or 0
    const Vec3d n = (p1 - p0).cross(p2 - p0);
    const double length = n.length();
    return length > 0 ? n / length : Vec3d(0.0);
  }
  // Largest distance of a corner of `other` from this one's plane.
  double distance_to(const Corners& other) const {
    const Vec3d n = normal();
    return std::max({std::abs((other.p0 - p0).dot(n)), std::abs((other.p1 - p0).dot(n)),
                     std::abs((other.p2 - p0).dot(n))});
  }
  // Whether `p`, all but in the plane, lies in the triangle.
  bool holds(const Vec3d& p) const {
    constexpr double kSlack = -1e-9;  // of the triangle: well above double's rounding
    const Vec3d e1 = p1 - p0, e2 = p2 - p0, d = p - p0, n = e1.cross(e2);
    const double scale = 1.0 / n.length2();
    const double u = d.cross(e2).dot(n) * scale, v = e1.cross(d).dot(n) * scale;
    return u >= kSlack && v >= kSlack && u + v <= 1.0 - kSlack;
  }
};

Corners corners_of(const EmissiveTriangle& t) {
  return {to_double(t.p0), to_double(t.p1), to_double(t.p2)};
}

Corners corners_of(const Mesh& mesh, const Instance& instance, uint32_t primitive) {
  const std::array<Vec3d, 3> p = placed_corners(mesh, instance, primitive);
  return {p[0], p[1], p[2]};
}

// One point of one emitter, asking for the triangles that it lies in.
struct Question {
  const std::vector<Mesh>& meshes;
  const std::vector<Instance>& instances;
  const EmissiveTriangle& emitter;
  Corners corners;
  Vec3d point;
  float error;         // of the emitter's plane
  float reach = 0.0f;  // the answer
  std::vector<std::pair<uint64_t, float>> surfaces;
};

bool answer(RTCPointQueryFunctionArguments* arguments) {
  Question& q = *static_cast<Question*>(arguments->userPtr);
  const uint32_t instance =
      arguments->context->instStackSize > 0 ? arguments->context->instID[0] : arguments->geomID;
  const uint32_t primitive = arguments->primID;
  if (instance == q.emitter.instance && primitive == q.emitter.primitive) return false;
  const Instance& placed = q.instances[instance];
  const Mesh& mesh = q.meshes[placed.mesh];
  const Corners other = corners_of(mesh, placed, primitive);
  if (!(other.normal().length2() > 0) || !other.holds(q.point)) return false;
  const float error = plane_error(mesh, placed, primitive) + q.error;
  // Of two triangles the plane of the smaller one says little about the far end of the larger.
  if (!(std::min(other.distance_to(q.corners), q.corners.distance_to(other)) <= double(error))) {
    return false;
  }
  // The planes lie that far apart, and Embree may see either that far from where it lies.
  q.reach = std::max(q.reach, 2.0f * error);
  q.surfaces.emplace_back(key_of(instance, primitive), 2.0f * error);
  return false;  // the radius stays
}

float largest_plane_error(const std::vector<Mesh>& meshes, const std::vector<Instance>& instances) {
  float largest = 0.0f;
  for (const Instance& instance : instances) {
    largest = std::max(largest, largest_plane_error(meshes[instance.mesh], instance));
  }
  return largest;
}

struct FlushContext {
  embree::RayContext ray;  // first, so that the filter can cast back
  const FlushEmitters* owner;
  FlushEmitters::Candidate best;
  Vec3f direction;
  float t;
  bool found;
};

}  // namespace

FlushEmitters::FlushEmitters(const std::vector<Mesh>& meshes,
                             const std::vector<Instance>& instances,
                             const std::vector<EmissiveTriangle>& emitters)
    : meshes_(meshes), instances_(instances), emitters_(emitters), reach_(emitters.size(), 0.0f) {}

FlushEmitters::~FlushEmitters() {
  if (scene_) rtcReleaseScene(scene_);
}

std::unique_ptr<FlushEmitters> FlushEmitters::find(const std::vector<Mesh>& meshes,
                                                   const std::vector<Instance>& instances,
                                                   const Geometry& geometry,
                                                   const std::vector<EmissiveTriangle>& emitters,
                                                   LoadProgress& progress) {
  std::unique_ptr<FlushEmitters> found(new FlushEmitters(meshes, instances, emitters));
  const float radius = 4.0f * largest_plane_error(meshes, instances);
  std::mutex mutex;
  parallel_ranges(emitters.size(), 64, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const EmissiveTriangle& e = emitters[i];
      if (is_black(e.mean_radiance)) continue;
      Question question{meshes, instances, e, corners_of(e), {}, 0.0f, 0.0f, {}};
      if (!(question.corners.normal().length2() > 0)) continue;
      question.error =
          plane_error(meshes[instances[e.instance].mesh], instances[e.instance], e.primitive);
      const Corners& c = question.corners;
      const Vec3d middle = (c.p0 + c.p1 + c.p2) / 3.0;
      const Vec3d points[] = {middle, c.p0 * 0.97 + middle * 0.03, c.p1 * 0.97 + middle * 0.03,
                              c.p2 * 0.97 + middle * 0.03};
      for (const Vec3d& point : std::span(points, emitters.size() > kManyEmitters ? 1 : 4)) {
        question.point = point;
        RTCPointQuery query;
        query.x = float(point.x);
        query.y = float(point.y);
        query.z = float(point.z);
        query.time = 0.0f;
        query.radius = radius;
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(geometry.top, &query, &context, answer, &question);
      }
      if (question.reach == 0.0f) continue;
      found->reach_[i] = question.reach;
      question.surfaces.emplace_back(key_of(e.instance, e.primitive), question.reach);
      const std::lock_guard lock(mutex);
      for (const auto& [key, reach] : question.surfaces) {
        float& offset = found->offsets_[key];
        offset = std::max(offset, reach);
      }
    }
    progress.advance(end - begin);
  });
  if (found->offsets_.empty()) return nullptr;
  found->build(geometry);
  return found;
}

void FlushEmitters::build(const Geometry& geometry) {
  for (uint32_t i = 0; i < reach_.size(); ++i) {
    if (reach_[i] == 0.0f) continue;
    members_.push_back(i);
    longest_reach_ = std::max(longest_reach_, reach_[i]);
  }
  RTCGeometry triangles = rtcNewGeometry(geometry.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const size_t n = members_.size();
  auto* vertices = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(
      triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), 3 * n));
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), n));
  if (vertices && indices) {
    for (size_t i = 0; i < n; ++i) {
      const EmissiveTriangle& e = emitters_[members_[i]];
      const Vec3f corners[3] = {e.p0, e.p1, e.p2};
      for (size_t c = 0; c < 3; ++c) {
        vertices[3 * i + c] = corners[c];
        indices[3 * i + c] = uint32_t(3 * i + c);
      }
    }
    rtcSetGeometryIntersectFilterFunction(triangles, keep_lowest);
    rtcCommitGeometry(triangles);
    scene_ = rtcNewScene(geometry.device);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene_, triangles);
    build_bvh(scene_, LoadProgress::unwatched(), n);
  }
  rtcReleaseGeometry(triangles);
}

float FlushEmitters::offset(uint32_t instance, uint32_t primitive) const {
  const auto found = offsets_.find(key_of(instance, primitive));
  return found == offsets_.end() ? 0.0f : found->second;
}

// Notes the lowest emitter and lets the ray go on: which comes first is what rounding decides.
void FlushEmitters::keep_lowest(const RTCFilterFunctionNArguments* arguments) {
  auto& context =
      *reinterpret_cast<FlushContext*>(reinterpret_cast<embree::RayContext*>(arguments->context));
  const FlushEmitters& self = *context.owner;
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1) continue;
    arguments->valid[i] = 0;
    const uint32_t index = self.members_[RTCHitN_primID(arguments->hit, arguments->N, i)];
    if (index >= context.best.emitter) continue;
    const EmissiveTriangle& e = self.emitters_[index];
    const float facing = dot(context.direction, Vec3f(corners_of(e).normal()));
    if (!e.two_sided && facing >= 0.0f) continue;
    const float t = RTCRayN_tfar(arguments->ray, arguments->N, i);
    if (!(std::abs((t - context.t) * facing) <= self.reach_[index])) continue;
    const Instance& placed = self.instances_[e.instance];
    float u = RTCHitN_u(arguments->hit, arguments->N, i);
    float v = RTCHitN_v(arguments->hit, arguments->N, i);
    // A mirrored instance's emitter lists its corners the other way round.
    if (placed.mirrored && placed.transformed) std::swap(u, v);
    const Mesh& mesh = self.meshes_[placed.mesh];
    if (mesh.has_coverage &&
        !covered(mesh, e.instance, e.primitive, u, v, context.ray.coverage_key)) {
      continue;
    }
    context.best = {index, t, u, v};
    context.found = true;
  }
}

bool FlushEmitters::lowest_at(const Vec3f& origin, const Vec3f& direction, float t, float cosine,
                              uint32_t coverage_key, Candidate* candidate) const {
  // Twice: the cosine is that of the other surface.
  const float slack = cosine > 0.0f ? 2.0f * longest_reach_ / cosine : t;
  RTCRayHit ray_hit;
  ray_hit.ray = make_ray(origin, direction, t + slack);
  ray_hit.ray.tnear = std::max(0.0f, t - slack);
  ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray_hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  FlushContext context{{}, this, *candidate, direction, t, false};
  embree::init_context(context.ray, coverage_key);
  embree::intersect(scene_, context.ray, ray_hit);
  if (context.found) *candidate = context.best;
  return context.found;
}

}  // namespace emberline::scene_detail
