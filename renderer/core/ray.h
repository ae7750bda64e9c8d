// Rays, their batch size and their largest coordinate.
#pragma once

#include <limits>

#include "renderer/core/vector.h"

namespace emberline {

// Maximum number of samples in a batch. The camera rays of a batch are computed together, and so
// are its environment lookups.
inline constexpr int kRayBatch = 16;

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The largest coordinate that the origin or unnormalised direction of a ray may have. Embree
// accepts up to 1.84e18 (FLT_LARGE in kernels/common/ray.h, 3.13 and 4) and aborts on larger ones
// if it was built with assertions, as Debian's Embree is. Squares overflow float beyond 1.8e19.
inline constexpr double kMaxOrigin = 1e18;

// The points origin + t * direction for t in [0, t_max], in the scene's internal space, which is
// shifted and scaled (see scene.h). Origins are already offset from their surface, so there is no
// t_min.
struct Ray {
  Vec3f origin;
  Vec3f direction;
  float t_max = kInfinity;
  float time = 0.0f;  // in [0, 1], from shutter open to close
};

}  // namespace emberline
