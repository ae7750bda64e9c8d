// Maps the unit square to the shapes that light transport samples. The inverse maps, and densities
// that only tests need, are in tests/support/warp_inverses.h.
//
// u is in [0, 1)^2. Directions are unit vectors. Densities are with respect to solid angle, unless
// their name says area. All functions are pure.
#pragma once

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline {

// Uniform in area on the unit disk. Shirley & Chiu 1997, "A Low Distortion Map Between Disk and
// Square".
Vec2f square_to_disk(const Vec2f& u);

// Cosine-weighted hemisphere around +Z (Malley's method).
Vec3f square_to_cosine_hemisphere(const Vec2f& u);

// Uniform on the unit sphere.
Vec3f square_to_sphere(const Vec2f& u);
float square_to_sphere_pdf(const Vec3f& w);

// Barycentric coordinates (b1, b2), uniform in area; b0 = 1 - b1 - b2. Heitz 2019, "A
// Low-Distortion Map Between Triangle and Square".
[[gnu::always_inline]] inline Vec2f square_to_triangle(const Vec2f& u) {
  const bool above = u.y > u.x;
  const float half = (above ? u.x : u.y) / 2, rest = (above ? u.y : u.x) - half;
  return above ? Vec2f(half, rest) : Vec2f(rest, half);
}

}  // namespace emberline
