// The densities and the inverses of the maps in renderer/core/warps.h, for tests.
#pragma once

#include "renderer/core/warps.h"

namespace emberline::test {

// The map to the unit disk. Its density is per area.
inline float square_to_disk_pdf(const Vec2f& p) { return p.dot(p) <= 1.0f ? kInvPi : 0.0f; }

inline Vec2f disk_to_square(const Vec2f& p) {
  const float r = std::sqrt(p.dot(p));
  float phi = std::atan2(p.y, p.x);
  if (phi < -kPi / 4) phi += 2 * kPi;  // in [-pi/4, 7pi/4), which consists of four wedges in order
  float a, b;
  if (phi < kPi / 4) {
    a = r;
    b = phi * a / (kPi / 4);
  } else if (phi < 3 * kPi / 4) {
    b = r;
    a = -(phi - kPi / 2) * b / (kPi / 4);
  } else if (phi < 5 * kPi / 4) {
    a = -r;
    b = (phi - kPi) * a / (kPi / 4);
  } else {
    b = -r;
    a = -(phi - 3 * kPi / 2) * b / (kPi / 4);
  }
  return {(a + 1) / 2, (b + 1) / 2};
}

// The map to the cosine-weighted hemisphere around +Z.
inline float square_to_cosine_hemisphere_pdf(const Vec3f& w) {
  return std::max(0.0f, w.z) * kInvPi;
}
inline Vec2f cosine_hemisphere_to_square(const Vec3f& w) { return disk_to_square({w.x, w.y}); }

// The inverse of the map that is uniform on the sphere.
inline Vec2f sphere_to_square(const Vec3f& w) {
  float phi = std::atan2(w.y, w.x);
  if (phi < 0) phi += 2 * kPi;
  return {(1.0f - w.z) / 2, phi / (2 * kPi)};
}

// The inverse of the map that is uniform in the area of a triangle. b contains barycentric
// coordinates.
inline Vec2f triangle_to_square(const Vec2f& b) {
  if (b.y > b.x) return {2 * b.x, b.y + b.x};
  return {b.x + b.y, 2 * b.y};
}

}  // namespace emberline::test
