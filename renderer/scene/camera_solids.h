// The solids that a camera stands in, so that its rays begin with what they are inside of.
#pragma once

#include <memory>
#include <span>

#include "renderer/scene/interior.h"

namespace emberline {

class Camera;

class CameraSolids {
 public:
  // Null if no camera ray starts in a solid. Warns of an open solid that seems to enclose the
  // camera: it counts as none. The scene outlives the result.
  static std::shared_ptr<const CameraSolids> find(const Scene& scene, const Camera& camera);

  // What each ray starts in. A function of its origin and time alone. Thread-safe.
  void interiors(std::span<const Ray> rays, std::span<Interior> out) const;

 private:
  explicit CameraSolids(const Scene& scene) : scene_(scene) {}

  const Scene& scene_;
  bool each_ray_ = false;  // the answer is not the same everywhere; else it is `everywhere_`
  Interior everywhere_;
};

}  // namespace emberline
