#include "integrators/recorders/occlusion.h"

#include "renderer/core/warps.h"
#include "renderer/film/channels.h"

namespace emberline {
namespace {

constexpr float kRadiusOfScene = 0.2f;
constexpr uint32_t kOcclusionSlot = 1u << 25;  // beyond those of any path and its light samples

}  // namespace

bool OcclusionRecorder::wanted(const SampleBatch& batch) {
  static const Aov ao = find_named(aov_table(), "`aov`", "channel", "ao").value;
  return batch.aovs && batch.aovs->contains(ao);
}

float OcclusionRecorder::openness(int lane) {
  const ShadedPoint& point = points_[lane];
  PixelSamples& samples = b_.samples;
  samples.resume_sample(lane);
  samples.start_slot(kOcclusionSlot);
  const Vec3f direction = point.frame.shading.to_world(square_to_cosine_hemisphere(
      {samples.get(surface_dim::kBsdfX), samples.get(surface_dim::kBsdfY)}));
  if (dot(direction, point.frame.geometric_normal) <= 0.0f) return 0.0f;
  const Vec3f from = point.spawn_origin(direction);
  const Vec3f to = from + direction * (kRadiusOfScene * b_.scene.radius());
  const float time = b_.batch.rays[size_t(lane)].time;
  return b_.scene.transmittance(from, to, time, coverage_key(b_.scene, samples));
}

}  // namespace emberline
