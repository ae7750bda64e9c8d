#include "integrators/recorders/specular_motion.h"

#include <array>

#include "renderer/film/channels.h"
#include "renderer/scene/camera.h"

namespace emberline {
namespace {

// A mirror is flat if the shading normal at the point is that of the triangle's corners, up to
// rounding.
constexpr float kFlatCosine = 1.0f - 1e-6f;

// The reflection about the plane of a triangle. If the triangle has no area, the matrix has NaNs.
Mat44d reflection(const std::array<Vec3d, 3>& corners) {
  const Vec3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  Mat44d m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[i][j] -= 2 * n[i] * n[j];
    m[3][i] = 2 * corners[0].dot(n) * n[i];
  }
  return m;
}

}  // namespace

bool SpecularMotionRecorder::is_enabled(const SampleBatch& batch) {
  return batch.aovs && batch.aovs->contains(Aov::kSpecularVelocity);
}

void SpecularMotionRecorder::record_surface(int lane) {
  State& state = states_[lane];
  if (!b_.points[lane].surface.material->unlit() && !b_.bsdfs[lane].has_non_delta()) return;
  state.is_specular = false;
  if (b_.depth == 0) return;
  const Scene::Motion motion = b_.scene.motion_of(b_.paths[lane].hit);
  const Vec3d from = motion.from * state.from, to = motion.to * state.to;
  record(lane, b_.batch.camera.velocity(from, to, b_.batch.velocity_frames));
}

// The background is infinitely far away, so only rotations move it.
void SpecularMotionRecorder::record_background(int lane) {
  State& state = states_[lane];
  state.is_specular = false;
  Vec3d direction;
  state.from.multDirMatrix(to_double(b_.paths[lane].ray.direction), direction);
  record(lane, b_.batch.camera.velocity(direction, b_.batch.velocity_frames));
}

void SpecularMotionRecorder::follow(int lane, const BsdfSample& next) {
  State& state = states_[lane];
  const ShadedPoint& point = b_.points[lane];
  if (next.delta && next.transmitted && point.material.bsdf.thin_walled) return;
  state.is_specular = next.delta && !next.transmitted;
  std::array<Vec3d, 3> from, to;
  for (size_t corner = 0; corner < 3 && state.is_specular; ++corner) {
    SurfaceHit hit = b_.paths[lane].hit;
    hit.u = corner == 1 ? 1.0f : 0.0f;
    hit.v = corner == 2 ? 1.0f : 0.0f;
    SurfaceInteraction surface;
    b_.scene.interaction(hit, b_.paths[lane].ray.time, &surface);
    const float cosine = dot(surface.shading_normal, point.frame.shading.normal);
    state.is_specular = std::abs(cosine) > kFlatCosine;
    const Scene::Motion motion = b_.scene.motion_of(hit);
    from[corner] = motion.from;
    to[corner] = motion.to;
  }
  if (!state.is_specular) return;
  state.from = reflection(from) * state.from;
  state.to = reflection(to) * state.to;
}

void SpecularMotionRecorder::record(int lane, const Vec2f& seen) {
  FirstHit& hit = b_.values[size_t(lane)].first_hit;
  hit.specular_velocity = {seen.x - hit.velocity.x, seen.y - hit.velocity.y};
}

}  // namespace emberline
