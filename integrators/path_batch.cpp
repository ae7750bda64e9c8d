#include "integrators/path_batch.h"

#include "renderer/lights/environment_guide.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_guide.h"

namespace emberline {

void PathBatch::eval_background(const LaneList& missed, Rgb* radiance) const {
  Vec3f directions[kRayBatch];
  for (int i = 0; i < missed.size(); ++i) {
    directions[i] = batch.rays[size_t(missed[i])].direction;
  }
  lights.environment()->radiance({directions, size_t(missed.size())}, radiance);
}

void PathBatch::eval_environment(const LaneList& missed, const LastVertex* const* from,
                                 Rgb* radiance, float* pdf) {
  Vec3f directions[kRayBatch];
  const auto count = size_t(missed.size());
  for (int i = 0; i < missed.size(); ++i) directions[i] = paths[missed[i]].ray.direction;
  if (!batch.guide || !batch.guide->environment) [[likely]] {
    lights.environment()->radiance_and_pdf({directions, count}, radiance, pdf);
    return;
  }
  const EnvironmentGuide& guide = *batch.guide->environment;
  int regions[kRayBatch];
  for (size_t i = 0; i < count; ++i) {
    const LightQuery& query = from[i]->query;
    const bool guided = from[i]->light_samples > 0 && !query.both_sides;
    regions[i] = guided ? guide.region_of(query.point, query.normal) : SkyRegions::kNone;
  }
  guide.radiance_and_pdf({directions, count}, {regions, count}, radiance, pdf);
}

}  // namespace emberline
