// Splits a transform into scale and skew, rotation, and translation, so that it can be
// interpolated.
#pragma once

#include <Imath/ImathQuat.h>

#include "renderer/core/vector.h"

namespace emberline {

// The transform applies a triangular matrix with the scales on its diagonal, then the rotation,
// then the translation. A mirrored transform has a negative scale along Z.
struct TransformParts {
  Vec3d size = Vec3d(1.0);
  double skew_xy = 0.0, skew_xz = 0.0, skew_yz = 0.0;
  Imath::Quatd rotation;
  Vec3d translation = Vec3d(0.0);

  explicit TransformParts(const Mat44d& m);  // `m` must not be singular
  Mat44d matrix() const;
};

// Interpolates scales, skews and translations linearly, and the rotation about a single axis, in
// the shorter direction.
TransformParts interpolate(const TransformParts& from, const TransformParts& to, double fraction);

}  // namespace emberline
