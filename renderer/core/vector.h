// Value types of the whole renderer: Imath vectors under the names this project uses.
//
// Rgb is linear Rec. 709 radiance or reflectance; products of two Rgb are component-wise.
// Directions named wo and wi point away from the surface.
#pragma once

#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace emberline {

using Vec2f = Imath::V2f;
using Vec2i = Imath::V2i;
using Vec3f = Imath::V3f;
using Vec3d = Imath::V3d;
using Vec4f = Imath::V4f;
using Mat44d = Imath::M44d;  // row vectors: p' = p * M, translation in the last row
using Rgb = Imath::V3f;

inline float dot(const Vec3f& a, const Vec3f& b) { return a.dot(b); }
inline double dot(const Vec3d& a, const Vec3d& b) { return a.dot(b); }
inline Vec3f cross(const Vec3f& a, const Vec3f& b) { return a.cross(b); }
inline Vec3d cross(const Vec3d& a, const Vec3d& b) { return a.cross(b); }

inline Vec3d to_double(const Vec3f& v) { return {v.x, v.y, v.z}; }
inline Vec3f to_float(const Vec3d& v) { return {float(v.x), float(v.y), float(v.z)}; }
// An affine matrix's image of a point; Imath's own divides by w.
inline Vec3d transform_point(const Mat44d& m, const Vec3d& p) {
  return {p.x * m[0][0] + p.y * m[1][0] + p.z * m[2][0] + m[3][0],
          p.x * m[0][1] + p.y * m[1][1] + p.z * m[2][1] + m[3][1],
          p.x * m[0][2] + p.y * m[1][2] + p.z * m[2][2] + m[3][2]};
}

// Rec. 709 luminance (ITU-R BT.709-6, section 3).
inline float luminance(const Rgb& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
inline float max_component(const Vec3f& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline float max_abs_component(const Vec3f& v) {
  return std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
}
inline bool is_black(const Rgb& c) { return c.x == 0.0f && c.y == 0.0f && c.z == 0.0f; }
inline bool is_finite(const Vec3f& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Unit vector along v; `fallback` when v is too short to have a direction (its squared length
// underflows float) or is not finite.
inline Vec3f normalize_or(const Vec3f& v, const Vec3f& fallback) {
  const float short_length2 = v.x * v.x + v.y * v.y + v.z * v.z;
  if (short_length2 > 1e-20f && short_length2 < 1e20f) {  // far from float's limits: the usual case
    return v * (1.0f / std::sqrt(short_length2));
  }
  const double length2 = double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z;
  if (!(length2 > 1e-60) || !std::isfinite(length2)) return fallback;
  const double scale = 1.0 / std::sqrt(length2);
  return {float(v.x * scale), float(v.y * scale), float(v.z * scale)};
}
inline Vec3f normalize(const Vec3f& v) { return v * (1.0f / std::sqrt(dot(v, v))); }

inline float square(float x) { return x * x; }
inline double square(double x) { return x * x; }
inline float lerp(float a, float b, float t) { return a + (b - a) * t; }
inline Rgb lerp(const Rgb& a, const Rgb& b, float t) { return a + (b - a) * t; }
inline float safe_sqrt(float x) { return std::sqrt(std::max(0.0f, x)); }

}  // namespace emberline
