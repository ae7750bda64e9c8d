// The hooks that PathLoop calls for recorders, and a recorder that does nothing in any of them.
#pragma once

#include "integrators/path_batch.h"

namespace emberline {

// As the policy of a PathLoop it compiles to nothing. `lane` numbers a path, whose state is in the
// PathBatch.
struct NoRecorder {
  explicit NoRecorder(PathBatch& /*batch*/) {}
  // Whether the batch asks for what this records.
  static bool wanted(const SampleBatch&) { return false; }

  // The camera ray has hit a surface.
  static void begin(int /*lane*/) {}
  // These camera rays have not; background() follows if they see the environment.
  static void camera_missed(const LaneList& /*missed*/) {}
  static void background(int /*lane*/, const Rgb& /*radiance*/) {}
  // All rays of PathBatch::alive have hit surfaces. May end paths.
  static void met_surfaces() {}
  // The surface's material and BSDF are known.
  static void shaded(int /*lane*/) {}

  // `light`, weighted by MIS, is about to be added to the path's radiance, times its throughput.
  // These return what is to be added instead. Emission of the surface:
  static Rgb emitted(int /*lane*/, const Rgb& light) { return light; }
  // The environment; `radiance` is without the MIS weight:
  static Rgb environment(int /*lane*/, const Rgb& /*radiance*/, const Rgb& light) { return light; }
  // A light sample that nothing hides:
  static Rgb connected(int /*lane*/, const Rgb& light) { return light; }

  // The path leaves the surface by this sample.
  static void scattered(int /*lane*/, const BsdfSample& /*next*/) {}
  // The scattered ray has hit nothing.
  static void missed(int /*lane*/) {}
  // All paths have ended, and the values of their samples are set. `hit`: the paths that began.
  static void ended(const LaneList& /*hit*/) {}
};

// The base of recorders, which hide the hooks that they use.
class Recorder : public NoRecorder {
 protected:
  explicit Recorder(PathBatch& batch) : NoRecorder(batch), b_(batch) {}
  PathBatch& b_;
};

}  // namespace emberline
