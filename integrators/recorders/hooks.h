// The hooks that PathLoop calls for recorders.
#pragma once

#include "integrators/path_batch.h"

namespace emberline {

// A recorder that does nothing; its hooks compile to nothing in PathLoop. Most comments below name
// the event after which PathLoop calls the hook. `lane` is the index of a path in the PathBatch.
struct NoRecorder {
  explicit NoRecorder(PathBatch& /*batch*/) {}
  // Returns whether the batch asks for the recorder's output.
  static bool is_enabled(const SampleBatch&) { return false; }

  // The camera ray has hit a surface.
  static void begin(int /*lane*/) {}
  // These camera rays have hit nothing. If they see the environment, background() is called next.
  static void camera_missed(const LaneList& /*missed*/) {}
  static void background(int /*lane*/, const Rgb& /*radiance*/) {}
  // All rays of PathBatch::alive have hit surfaces. The hook may end paths.
  static void surfaces_hit() {}
  // The surface's material and BSDF are known.
  static void shaded(int /*lane*/) {}

  // The next three hooks are called before `light` is added to the path's radiance, and return the
  // light to add instead. `light` includes the MIS weight but not the throughput. This hook is for
  // light that the surface emits.
  static Rgb emitted(int /*lane*/, const Rgb& light) { return light; }
  // This hook is for the environment's light; `radiance` excludes the MIS weight.
  static Rgb environment(int /*lane*/, const Rgb& /*radiance*/, const Rgb& light) { return light; }
  // This hook is for an unoccluded light sample.
  static Rgb connected(int /*lane*/, const Rgb& light) { return light; }

  // The path leaves the surface in the direction of this sample.
  static void scattered(int /*lane*/, const BsdfSample& /*next*/) {}
  // The scattered ray has left the scene.
  static void missed(int /*lane*/) {}
  // All paths have ended and the sample values are set. `hit` lists the paths whose camera ray hit
  // a surface.
  static void paths_ended(const LaneList& /*hit*/) {}
};

// Base class of all recorders. A recorder implements a hook by hiding the inherited function.
class Recorder : public NoRecorder {
 protected:
  explicit Recorder(PathBatch& batch) : NoRecorder(batch), b_(batch) {}
  PathBatch& b_;
};

}  // namespace emberline
