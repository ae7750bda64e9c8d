// Records FirstHit::specular_velocity: how what is seen in mirrors and through clear glass moves,
// compared with the mirror or the glass itself.
#pragma once

#include "integrators/recorders/hooks.h"

namespace emberline {

// The motion is known behind flat mirrors, which may move, and behind thin walls. It is 0 where a
// path is bent: at curved mirrors, at normal maps and at solid glass.
class SpecularMotionRecorder : public Recorder {
 public:
  explicit SpecularMotionRecorder(PathBatch& batch)
      : Recorder(batch), is_enabled_(is_enabled(batch.batch)) {}
  static bool is_enabled(const SampleBatch& batch);

  void begin(int lane) {
    if (is_enabled_) states_.emplace(lane);
  }
  void shaded(int lane) {
    if (is_enabled_ && states_[lane].is_specular) record_surface(lane);
  }
  void scattered(int lane, const BsdfSample& next) {
    if (is_enabled_ && states_[lane].is_specular) follow(lane, next);
  }
  void missed(int lane) {
    if (is_enabled_ && states_[lane].is_specular) record_background(lane);
  }

 private:
  // These matrices map points to their images in the mirrors so far, at the beginning and at the
  // end of the motion.
  struct State {
    bool is_specular = true;  // the path has met only flat mirrors and thin walls
    Mat44d from, to;
  };

  void record_surface(int lane);
  void record_background(int lane);
  void follow(int lane, const BsdfSample& next);
  void record(int lane, const Vec2f& seen);

  const bool is_enabled_;
  LaneArray<State> states_;
};

}  // namespace emberline
