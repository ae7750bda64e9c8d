// Finds the solids that contain the camera, so that the camera's rays start in the right interior.
#pragma once

#include <memory>
#include <span>

#include "renderer/scene/interior.h"

namespace emberline {

class Camera;

class CameraSolids {
 public:
  // Returns null if no camera ray starts in a solid. Warns about an open solid that seems to
  // enclose the camera and ignores it. The scene must outlive the result.
  static std::shared_ptr<const CameraSolids> find(const Scene& scene, const Camera& camera);

  // Stores in `out` the interior in which each ray starts. A ray's interior depends only on its
  // origin and time. Thread-safe.
  void interiors(std::span<const Ray> rays, std::span<Interior> out) const;

 private:
  explicit CameraSolids(const Scene& scene) : scene_(scene) {}

  const Scene& scene_;
  // True if rays may start in different interiors. If false, all rays start in `common_interior_`.
  bool differs_per_ray_ = false;
  Interior common_interior_;
};

}  // namespace emberline
