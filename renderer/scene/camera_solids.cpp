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

// Unit vectors that are not parallel to any axis or diagonal of a typical scene.
constexpr std::array<Vec3f, 3> kDirections = {
    {{0.5373f, 0.7306f, 0.4213f}, {-0.7117f, 0.2093f, -0.6706f}, {0.3221f, -0.6137f, 0.7209f}}};

// For each solid, the number of exits minus the number of entries along a ray.
using WindingNumbers = std::map<uint32_t, int>;

WindingNumbers winding_numbers_along(const Scene& scene, const Vec3f& origin,
                                     const Vec3f& direction, float time) {
  constexpr int kMaxSurfaces = 100'000;
  const Solids& solids = *scene.solids();
  WindingNumbers winding_numbers;
  Ray ray{origin, direction, kInfinity, time};
  SurfaceHit hit;
  for (int i = 0; i < kMaxSurfaces && scene.intersect(ray, CoverageKey(), &hit); ++i) {
    SurfaceInteraction surface;
    scene.interaction(hit, time, &surface);
    if (surface.material->is_solid()) {
      const SolidCrossing crossing(scene, surface, hit, ray, CoverageKey());
      for (const CrossedFace& face : crossing) {
        winding_numbers[solids.body(face.hit.instance)] += face.is_exit ? 1 : -1;
      }
      surface.offset = crossing.offset();
    } else if (const auto part = solids.opaque_parts().find(hit.instance);
               part != solids.opaque_parts().end()) {
      winding_numbers[part->second] += dot(direction, surface.geometric_normal) > 0.0f ? 1 : -1;
    }
    ray.origin =
        offset_ray_origin(surface.position, surface.geometric_normal, surface.offset, direction);
  }
  return winding_numbers;
}

void enter_closed(const Scene& scene, const WindingNumbers& winding_numbers, Interior* interior) {
  for (const auto& [instance, winding] : winding_numbers) {
    if (winding > 0 && scene.solids()->closed(instance)) interior->enter(scene, instance);
  }
}

}  // namespace

std::shared_ptr<const CameraSolids> CameraSolids::find(const Scene& scene, const Camera& camera) {
  const Solids* const solids = scene.solids();
  if (!solids) return nullptr;
  const Imath::Box3f origin_bounds = camera.origin_bounds();
  const bool is_single_origin = origin_bounds.min == origin_bounds.max;
  bool has_candidates = false, differs_per_ray = false;
  const auto add_candidate = [&](uint32_t surface, uint32_t body) {
    if (!solids->bounds_over_shutter(scene, body).intersects(origin_bounds)) return;
    has_candidates = true;
    differs_per_ray =
        differs_per_ray || (solids->closed(body) &&
                            (scene.moves(surface) ||
                             (!is_single_origin && scene.has_faces_near(surface, origin_bounds))));
  };
  for (const uint32_t i : solids->instances()) add_candidate(i, solids->body(i));
  for (const auto& [i, body] : solids->opaque_parts()) add_candidate(i, body);
  if (!has_candidates) return nullptr;

  std::shared_ptr<CameraSolids> found(new CameraSolids(scene));
  found->differs_per_ray_ = differs_per_ray;
  // A ray that meets an edge may count wrongly, so the camera counts as inside a solid if at least
  // two of the three rays say so.
  std::map<uint32_t, int> votes;
  for (const Vec3f& direction : kDirections) {
    for (const auto& [instance, winding] :
         winding_numbers_along(scene, origin_bounds.center(), direction, 0.0f)) {
      votes[instance] += winding > 0;
    }
  }
  WindingNumbers inside;
  for (const auto& [instance, count] : votes) {
    if (count < 2) continue;
    inside[instance] = 1;
    if (solids->closed(instance)) continue;
    log_warning(
        fmt::format("the camera seems to be inside '{}', whose mesh is not closed; the picture "
                    "is not tinted by the inside of this mesh",
                    solids->open_name(instance)));
  }
  enter_closed(scene, inside, &found->common_interior_);
  return found->differs_per_ray_ || !found->common_interior_.empty() ? found : nullptr;
}

void CameraSolids::interiors(std::span<const Ray> rays, std::span<Interior> out) const {
  for (size_t i = 0; i < rays.size(); ++i) {
    out[i] = common_interior_;
    if (!differs_per_ray_) continue;
    out[i] = Interior();
    enter_closed(scene_,
                 winding_numbers_along(scene_, rays[i].origin, kDirections[0], rays[i].time),
                 &out[i]);
  }
}

}  // namespace emberline
