#include "integrators/recorders/occlusion.h"

#include "integrators/ambient_visibility.h"
#include "renderer/film/channels.h"

namespace emberline {

bool OcclusionRecorder::is_enabled(const SampleBatch& batch) {
  static const Aov ao = find_named(aov_table(), "`aov`", "channel", "ao").value;
  return batch.aovs && batch.aovs->contains(ao);
}

void OcclusionRecorder::paths_ended(const LaneList&) {
  // This slot lies beyond all slots that paths and their light samples use.
  constexpr uint32_t kOcclusionSlot = 1u << 25;
  for (const int lane : lanes_) {
    b_.samples.resume_sample(lane);
    b_.samples.start_slot(kOcclusionSlot);
    FirstHit& hit = b_.values[size_t(lane)].first_hit;
    hit.hit = true;
    const float time = b_.batch.rays[size_t(lane)].time;
    hit.ambient_visibility = ambient_visibility(b_.scene, points_[lane], time, b_.samples, nullptr);
  }
}

}  // namespace emberline
