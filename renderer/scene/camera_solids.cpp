#include "renderer/scene/camera_solids.h"

#include <fmt/format.h>

#include <array>
#include <map>

#include "renderer/core/log.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/solids.h"

namespace emberline {
namespace {

// Unit vectors, not along any axis or diagonal of a scene.
constexpr std::array<Vec3f, 3> kDirections = {
    {{0.5373f, 0.7306f, 0.4213f}, {-0.7117f, 0.2093f, -0.6706f}, {0.3221f, -0.6137f, 0.7209f}}};

// Per solid: the number of exits minus the number of entries along a ray.
using Windings = std::map<uint32_t, int>;

Windings windings_along(const Scene& scene, const Vec3f& origin, const Vec3f& direction,
                        float time) {
  constexpr int kMostSurfaces = 100'000;
  const Solids& solids = *scene.solids();
  Windings windings;
  Ray ray{origin, direction, kInfinity, time};
  SurfaceHit hit;
  for (int i = 0; i < kMostSurfaces && scene.intersect(ray, CoverageKey(), &hit); ++i) {
    SurfaceInteraction surface;
    scene.interaction(hit, time, &surface);
    if (surface.material->is_solid()) {
      const SolidCrossing crossing(scene, surface, hit, ray, CoverageKey());
      for (const CrossedFace& face : crossing) {
        windings[solids.body(face.hit.instance)] += face.back ? 1 : -1;
      }
      surface.offset = crossing.offset();
    } else if (const auto part = solids.opaque_parts().find(hit.instance);
               part != solids.opaque_parts().end()) {
      windings[part->second] += dot(direction, surface.geometric_normal) > 0.0f ? 1 : -1;
    }
    ray.origin =
        offset_ray_origin(surface.position, surface.geometric_normal, surface.offset, direction);
  }
  return windings;
}

void enter_closed(const Scene& scene, const Windings& windings, Interior* interior) {
  for (const auto& [instance, winding] : windings) {
    if (winding > 0 && scene.solids()->closed(instance)) interior->enter(scene, instance);
  }
}

}  // namespace

std::shared_ptr<const CameraSolids> CameraSolids::find(const Scene& scene, const Camera& camera) {
  const Solids* const solids = scene.solids();
  if (!solids) return nullptr;
  const Imath::Box3f origins = camera.origins();
  const bool one_place = origins.min == origins.max;
  bool any_around = false, each_ray = false;
  const auto look_at = [&](uint32_t surface, uint32_t body) {
    if (!solids->bounds_over_shutter(scene, body).intersects(origins)) return;
    any_around = true;
    each_ray = each_ray ||
               (solids->closed(body) &&
                (scene.moves(surface) || (!one_place && scene.has_faces_near(surface, origins))));
  };
  for (const uint32_t i : solids->instances()) look_at(i, solids->body(i));
  for (const auto& [i, body] : solids->opaque_parts()) look_at(i, body);
  if (!any_around) return nullptr;

  std::shared_ptr<CameraSolids> found(new CameraSolids(scene));
  found->each_ray_ = each_ray;
  // A ray that meets an edge may be counted wrongly, so two of three rays decide.
  std::map<uint32_t, int> votes;
  for (const Vec3f& direction : kDirections) {
    for (const auto& [instance, winding] :
         windings_along(scene, origins.center(), direction, 0.0f)) {
      votes[instance] += winding > 0;
    }
  }
  Windings inside;
  for (const auto& [instance, count] : votes) {
    if (count < 2) continue;
    inside[instance] = 1;
    if (solids->closed(instance)) continue;
    log_warning(
        fmt::format("the camera seems to be inside '{}', whose mesh is not closed: its inside is "
                    "unknown and does not tint the picture",
                    solids->open_name(instance)));
  }
  enter_closed(scene, inside, &found->everywhere_);
  return found->each_ray_ || !found->everywhere_.empty() ? found : nullptr;
}

void CameraSolids::interiors(std::span<const Ray> rays, std::span<Interior> out) const {
  for (size_t i = 0; i < rays.size(); ++i) {
    out[i] = everywhere_;
    if (!each_ray_) continue;
    out[i] = Interior();
    enter_closed(scene_, windings_along(scene_, rays[i].origin, kDirections[0], rays[i].time),
                 &out[i]);
  }
}

}  // namespace emberline
