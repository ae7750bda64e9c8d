// Value types of the renderer: Imath vectors under project names.
//
// Rgb is linear radiance or reflectance. Its primaries are Rec. 709 in scene descriptions and those
// of the working space in the renderer (colour_matrix.h). The product of two Rgb is component-wise.
// Directions named wo and wi point away from the surface.
#pragma once

#include <Imath/ImathMatrix.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace emberline {

using Vec2f = Imath::V2f;
using Vec2i = Imath::V2i;
using Vec3f = Imath::V3f;
using Vec3d = Imath::V3d;
using Vec4f = Imath::V4f;
using Mat44d = Imath::M44d;  // row vectors: p' = p * M, translation in the last row
using Rgb = Imath::V3f;

// a * b + c, rounded once. The compiler does not fuse by itself (-ffp-contract=off), because the
// bits of an image must not depend on what the compiler inlines. Hot code fuses explicitly with
// these functions and the vector products below, whereas Imath's own operators round every product.
// The functions are always_inline, since GCC counts std::fma as a call when it decides what to
// inline.
[[gnu::always_inline]] inline float fma(float a, float b, float c) { return std::fma(a, b, c); }
[[gnu::always_inline]] inline double fma(double a, double b, double c) { return std::fma(a, b, c); }
[[gnu::always_inline]] inline Vec2f fma(const Vec2f& a, float b, const Vec2f& c) {
  return {fma(a.x, b, c.x), fma(a.y, b, c.y)};
}
template <class T>
[[gnu::always_inline]] inline Imath::Vec3<T> fma(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b,
                                                 const Imath::Vec3<T>& c) {
  return {fma(a.x, b.x, c.x), fma(a.y, b.y, c.y), fma(a.z, b.z, c.z)};
}
template <class T>
[[gnu::always_inline]] inline Imath::Vec3<T> fma(const Imath::Vec3<T>& a, std::type_identity_t<T> b,
                                                 const Imath::Vec3<T>& c) {
  return {fma(a.x, b, c.x), fma(a.y, b, c.y), fma(a.z, b, c.z)};
}
[[gnu::always_inline]] inline Vec4f fma(const Vec4f& a, float b, const Vec4f& c) {
  return {fma(a.x, b, c.x), fma(a.y, b, c.y), fma(a.z, b, c.z), fma(a.w, b, c.w)};
}

template <class T>
[[gnu::always_inline]] inline T dot(const Imath::Vec3<T>& a, const Imath::Vec3<T>& b) {
  return fma(a.z, b.z, fma(a.y, b.y, a.x * b.x));
}
template <class T>
[[gnu::always_inline]] inline Imath::Vec3<T> cross(const Imath::Vec3<T>& a,
                                                   const Imath::Vec3<T>& b) {
  return {fma(a.y, b.z, -(a.z * b.y)), fma(a.z, b.x, -(a.x * b.z)), fma(a.x, b.y, -(a.y * b.x))};
}

inline Vec3d to_double(const Vec3f& v) { return {v.x, v.y, v.z}; }
inline Vec3f to_float(const Vec3d& v) { return {float(v.x), float(v.y), float(v.z)}; }
inline Vec3d row(const Mat44d& m, int i) { return {m[i][0], m[i][1], m[i][2]}; }
// Transforms a point by an affine matrix, without Imath's division by w.
inline Vec3d transform_point(const Mat44d& m, const Vec3d& p) {
  return fma(row(m, 0), p.x, fma(row(m, 1), p.y, fma(row(m, 2), p.z, row(m, 3))));
}

// Returns the Rec. 709 luminance (ITU-R BT.709-6, section 3).
[[gnu::always_inline]] inline float luminance(const Rgb& c) {
  return dot(c, Rgb(0.2126f, 0.7152f, 0.0722f));
}
inline float max_component(const Vec3f& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline float max_abs_component(const Vec3f& v) {
  return std::max(std::abs(v.x), std::max(std::abs(v.y), std::abs(v.z)));
}
inline double max_abs_component(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}
inline bool is_black(const Rgb& c) { return c.x == 0.0f && c.y == 0.0f && c.z == 0.0f; }
inline bool is_finite(const Vec3f& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Returns the unit vector along v, or `fallback` if v is not finite or is too short (squared length
// below 1e-60).
inline Vec3f normalize_or(const Vec3f& v, const Vec3f& fallback) {
  const float short_length2 = dot(v, v);
  if (short_length2 > 1e-20f && short_length2 < 1e20f) {  // common case: no over- or underflow
    return v * (1.0f / std::sqrt(short_length2));
  }
  const double length2 = dot(to_double(v), to_double(v));
  if (!(length2 > 1e-60) || !std::isfinite(length2)) return fallback;
  const double scale = 1.0 / std::sqrt(length2);
  return {float(v.x * scale), float(v.y * scale), float(v.z * scale)};
}
[[gnu::always_inline]] inline Vec3f normalize(const Vec3f& v) {
  return v * (1.0f / std::sqrt(dot(v, v)));
}

inline float square(float x) { return x * x; }
inline double square(double x) { return x * x; }
inline float pow5(float x) { return square(square(x)) * x; }
[[gnu::always_inline]] inline float lerp(float a, float b, float t) { return fma(b - a, t, a); }
[[gnu::always_inline]] inline Rgb lerp(const Rgb& a, const Rgb& b, float t) {
  return fma(b - a, t, a);
}
inline float safe_sqrt(float x) { return std::sqrt(std::max(0.0f, x)); }

}  // namespace emberline
