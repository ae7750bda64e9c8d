// Records ambient occlusion of the first surface (openness.h).
#pragma once

#include "integrators/recorders/hooks.h"

namespace emberline {

class OcclusionRecorder : public Recorder {
 public:
  explicit OcclusionRecorder(PathBatch& batch) : Recorder(batch), on_(wanted(batch.batch)) {}
  static bool wanted(const SampleBatch& batch);

  void shaded(int lane) {
    if (!on_ || b_.depth > 0) return;
    seen_.add(lane);
    points_.emplace(lane) = b_.points[lane];
  }
  // Runs after the paths, with random numbers that no path uses, so that no other channel changes.
  // The ray is not counted, since the cost of a pixel steers adaptive sampling.
  void ended(const LaneList&);

 private:
  const bool on_;
  LaneList seen_;
  LaneArray<ShadedPoint> points_;
};

}  // namespace emberline
