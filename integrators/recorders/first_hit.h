// Records the AOVs of the first surface (FirstHit).
#pragma once

#include "integrators/recorders/hooks.h"

namespace emberline {

class FirstHitRecorder : public Recorder {
 public:
  explicit FirstHitRecorder(PathBatch& batch) : Recorder(batch) {}
  static bool is_enabled(const SampleBatch& batch) { return batch.surface_aovs || batch.hit_id; }

  void shaded(int lane) {
    if (b_.depth > 0) return;
    fill_first_hit(b_.batch, b_.paths[lane].hit, b_.points[lane], b_.paths[lane].ray.time,
                   b_.bsdfs[lane].albedo(), &b_.values[size_t(lane)].first_hit);
  }
};

}  // namespace emberline
