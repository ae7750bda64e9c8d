// Computes reference values for tests: the exact irradiance of polygonal lights, in double
// precision.
#pragma once

#include <cmath>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline::test {

inline Vec3d unit(const Vec3d& v) { return v / std::sqrt(dot(v, v)); }

// Returns the angle between unit vectors. Unlike acos, it has no cancellation near 0.
inline double angle_between(const Vec3d& a, const Vec3d& b) {
  const Vec3d c = cross(a, b);
  return std::atan2(std::sqrt(dot(c, c)), dot(a, b));
}

// Returns Lambert's vector irradiance at the origin from a polygon of radiance 1 (Arvo 1994, "The
// Irradiance Jacobian for Partially Occluded Polyhedral Sources", equation 1). If the whole polygon
// is above the horizon of a normal, the dot product of this vector and the normal is the
// irradiance.
inline Vec3d vector_irradiance(const std::vector<Vec3d>& polygon) {
  Vec3d sum(0.0);
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d a = unit(polygon[i]), b = unit(polygon[(i + 1) % polygon.size()]);
    const Vec3d n = cross(a, b);
    const double sine = std::sqrt(dot(n, n));
    if (sine > 0) sum += n * (angle_between(a, b) / sine);
  }
  return sum * 0.5;
}

// Returns the irradiance at `point` with normal `n` from a polygon of radiance 1. Clips the polygon
// to the horizon (Sutherland & Hodgman 1974). The polygon is two-sided, so its orientation does not
// matter.
inline double polygon_irradiance(std::vector<Vec3d> polygon, const Vec3d& point, const Vec3d& n) {
  std::vector<Vec3d> above;
  for (Vec3d& v : polygon) v -= point;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d& a = polygon[i];
    const Vec3d& b = polygon[(i + 1) % polygon.size()];
    const double ha = dot(a, n), hb = dot(b, n);
    if (ha >= 0) above.push_back(a);
    if ((ha < 0) != (hb < 0)) above.push_back(a + (b - a) * (ha / (ha - hb)));
  }
  return above.size() < 3 ? 0.0 : std::abs(dot(vector_irradiance(above), n));
}

// Returns the solid angle of a spherical triangle from the sum of its vertex angles (Girard). The
// vertex angles are the angles between the planes of its sides. In double precision this is
// accurate enough for the tests, and it is independent of the arctangent form.
inline double girard_solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
  return kPiD - angle_between(unit(ab), unit(bc)) + kPiD - angle_between(unit(bc), unit(ca)) +
         kPiD - angle_between(unit(ca), unit(ab)) - kPiD;
}

}  // namespace emberline::test
