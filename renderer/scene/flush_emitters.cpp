#include "renderer/scene/flush_emitters.h"

#include <algorithm>
#include <cmath>

namespace emberline::scene_detail {
namespace {

Vec3f unit_normal(const EmissiveTriangle& t) {  // 0 if the triangle is degenerate
  const Vec3d p0 = to_double(t.p0);
  return to_float((to_double(t.p1) - p0).cross(to_double(t.p2) - p0).normalized());
}

struct FlushContext {
  embree::RayContext ray;  // must be first, so that the filter can cast back
  const FlushEmitters* owner;
  FlushEmitters::Candidate best;
  Vec3f direction;
  float t;
  bool found;
};

}  // namespace

FlushEmitters::~FlushEmitters() {
  if (scene_) rtcReleaseScene(scene_);
}

std::unique_ptr<FlushEmitters> FlushEmitters::find(const PlacedEmitters& placed,
                                                   const Geometry& geometry,
                                                   LoadProgress& progress) {
  FlushSurfaces surfaces = find_flush_surfaces(placed, progress);
  if (surfaces.offsets.empty()) return nullptr;
  std::unique_ptr<FlushEmitters> found(new FlushEmitters(placed, std::move(surfaces)));
  found->build(geometry);
  return found;
}

void FlushEmitters::build(const Geometry& geometry) {
  for (uint32_t i = 0; i < surfaces_.reach.size(); ++i) {
    if (surfaces_.reach[i] == 0.0f) continue;
    flush_emitters_.push_back(i);
    max_reach_ = std::max(max_reach_, surfaces_.reach[i]);
  }
  RTCGeometry triangles = rtcNewGeometry(geometry.device()->handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const size_t n = flush_emitters_.size();
  auto* vertices = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(
      triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3f), 3 * n));
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), n));
  if (vertices && indices) {
    for (size_t i = 0; i < n; ++i) {
      const EmissiveTriangle& e = placed_.emitters[flush_emitters_[i]];
      const Vec3f corners[3] = {e.p0, e.p1, e.p2};
      for (size_t c = 0; c < 3; ++c) {
        vertices[3 * i + c] = corners[c];
        indices[3 * i + c] = uint32_t(3 * i + c);
      }
    }
    rtcSetGeometryIntersectFilterFunction(triangles, keep_lowest);
    rtcCommitGeometry(triangles);
    scene_ = rtcNewScene(geometry.device()->handle());
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene_, triangles);
    build_bvh(scene_, LoadProgress::none(), n);
  }
  rtcReleaseGeometry(triangles);
}

float FlushEmitters::offset(uint32_t instance, uint32_t primitive) const {
  const auto found = surfaces_.offsets.find(surface_key(instance, primitive));
  return found == surfaces_.offsets.end() ? 0.0f : found->second;
}

// Keeps the emitter with the lowest index and continues the ray, since rounding decides the order
// of hits.
void FlushEmitters::keep_lowest(const RTCFilterFunctionNArguments* arguments) {
  auto& context =
      *reinterpret_cast<FlushContext*>(reinterpret_cast<embree::RayContext*>(arguments->context));
  const FlushEmitters& self = *context.owner;
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != -1) continue;
    arguments->valid[i] = 0;
    const uint32_t index = self.flush_emitters_[RTCHitN_primID(arguments->hit, arguments->N, i)];
    if (index >= context.best.emitter) continue;
    const EmissiveTriangle& e = self.placed_.emitters[index];
    const float facing = dot(context.direction, unit_normal(e));
    if (!e.two_sided && facing >= 0.0f) continue;
    if (e.has_visibility_times &&
        !self.placed_.visibility[e.instance]->at(RTCRayN_time(arguments->ray, arguments->N, i))) {
      continue;
    }
    const float t = RTCRayN_tfar(arguments->ray, arguments->N, i);
    if (!(std::abs((t - context.t) * facing) <= self.surfaces_.reach[index])) continue;
    const Instance& placed = self.placed_.instances[e.instance];
    float u = RTCHitN_u(arguments->hit, arguments->N, i);
    float v = RTCHitN_v(arguments->hit, arguments->N, i);
    // An emitter of a mirrored instance lists its corners in reverse order.
    if (placed.mirrored && placed.transformed) std::swap(u, v);
    const Mesh& mesh = self.placed_.meshes[placed.mesh];
    if (mesh.has_coverage &&
        !is_covered(mesh, e.instance, e.primitive, u, v, context.ray.coverage_key)) {
      continue;
    }
    context.best = {index, t, u, v};
    context.found = true;
  }
}

bool FlushEmitters::find_lowest_emitter(const Ray& ray, float t, float cosine,
                                        CoverageKey coverage_key, Candidate* candidate) const {
  // Use twice the reach, since `cosine` belongs to the surface that was hit, not to the emitter.
  const float slack = cosine > 0.0f ? 2.0f * max_reach_ / cosine : t;
  RTCRayHit ray_hit = make_ray_hit(make_ray(ray.origin, ray.direction, t + slack, ray.time));
  ray_hit.ray.tnear = std::max(0.0f, t - slack);
  FlushContext context{{}, this, *candidate, ray.direction, t, false};
  embree::init_context(context.ray, coverage_key);
  embree::intersect(scene_, context.ray, ray_hit);
  if (context.found) *candidate = context.best;
  return context.found;
}

}  // namespace emberline::scene_detail
