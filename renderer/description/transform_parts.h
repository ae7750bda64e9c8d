// A transform as sizes and skews, a rotation and a shift: what it goes through on the way to
// another one.
#pragma once

#include <Imath/ImathQuat.h>

#include "renderer/core/vector.h"

namespace emberline {

// A triangular matrix (sizes on its diagonal), then the rotation, then the translation. A mirror is
// a negative size along Z.
struct TransformParts {
  Vec3d size = Vec3d(1.0);
  double skew_xy = 0.0, skew_xz = 0.0, skew_yz = 0.0;
  Imath::Quatd rotation;
  Vec3d translation = Vec3d(0.0);

  explicit TransformParts(const Mat44d& m);  // not singular
  Mat44d matrix() const;
};

// At `share` of the way: sizes, skews and positions go along straight lines, and it turns about one
// axis, the shorter way.
TransformParts between(const TransformParts& from, const TransformParts& to, double share);

}  // namespace emberline
