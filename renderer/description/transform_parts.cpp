#include "renderer/description/transform_parts.h"

#include <Imath/ImathMatrixAlgo.h>

namespace emberline {

// Orthogonalises the transformed axes by Gram-Schmidt, which gives the rotation. The scales and
// skews that this removes form the triangular matrix.
TransformParts::TransformParts(const Mat44d& m) : translation(row(m, 3)) {
  const Vec3d x = row(m, 0), y = row(m, 1), z = row(m, 2);
  const Vec3d axes[3] = {x.normalized(), (y - x.normalized() * dot(x.normalized(), y)).normalized(),
                         cross(x.normalized(), y).normalized()};
  size = Vec3d(dot(axes[0], x), dot(axes[1], y), dot(axes[2], z));
  skew_xy = dot(axes[0], y);
  skew_xz = dot(axes[0], z);
  skew_yz = dot(axes[1], z);
  Mat44d rotation_matrix;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rotation_matrix[r][c] = axes[r][c];
  }
  rotation = Imath::extractQuat(rotation_matrix);
}

Mat44d TransformParts::matrix() const {
  const Imath::M33d axes = rotation.toMatrix33();
  Mat44d m;
  for (int c = 0; c < 3; ++c) {
    m[0][c] = size.x * axes[0][c];
    m[1][c] = skew_xy * axes[0][c] + size.y * axes[1][c];
    m[2][c] = skew_xz * axes[0][c] + skew_yz * axes[1][c] + size.z * axes[2][c];
    m[3][c] = translation[c];
  }
  return m;
}

TransformParts interpolate(const TransformParts& from, const TransformParts& to, double fraction) {
  const auto blend = [fraction](const auto& a, const auto& b) { return a + (b - a) * fraction; };
  TransformParts parts = from;
  parts.size = blend(from.size, to.size);
  parts.skew_xy = blend(from.skew_xy, to.skew_xy);
  parts.skew_xz = blend(from.skew_xz, to.skew_xz);
  parts.skew_yz = blend(from.skew_yz, to.skew_yz);
  parts.translation = blend(from.translation, to.translation);
  parts.rotation = Imath::slerpShortestArc(from.rotation, to.rotation, fraction);
  return parts;
}

}  // namespace emberline
