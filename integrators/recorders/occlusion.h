// Records ambient occlusion of the first surface (ambient_visibility.h).
#pragma once

#include "integrators/recorders/hooks.h"

namespace emberline {

class OcclusionRecorder : public Recorder {
 public:
  explicit OcclusionRecorder(PathBatch& batch)
      : Recorder(batch), is_enabled_(is_enabled(batch.batch)) {}
  static bool is_enabled(const SampleBatch& batch);

  void shaded(int lane) {
    if (!is_enabled_ || b_.depth > 0) return;
    lanes_.add(lane);
    points_.emplace(lane) = b_.points[lane];
  }
  // Traces the occlusion rays after all paths have ended, with random numbers that no path uses. So
  // no other channel changes. The rays are not counted, since adaptive sampling depends on the
  // counted cost of a pixel.
  void paths_ended(const LaneList&);

 private:
  const bool is_enabled_;
  LaneList lanes_;
  LaneArray<ShadedPoint> points_;
};

}  // namespace emberline
