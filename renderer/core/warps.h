// Maps the unit square to the shapes that light transport samples. The inverse maps, and densities
// that only tests need, are in tests/support/warp_inverses.h.
//
// u is in [0, 1)^2. Directions are unit vectors. Densities are with respect to solid angle. All
// functions are pure.
#pragma once

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline {

// Maps uniformly in area to the unit disk. The method is from Shirley & Chiu 1997, "A Low
// Distortion Map Between Disk and Square".
Vec2f square_to_disk(const Vec2f& u);

// Maps to the hemisphere around +Z with a cosine-weighted density (Malley's method).
Vec3f square_to_cosine_hemisphere(const Vec2f& u);

// Maps uniformly to the unit sphere.
Vec3f square_to_sphere(const Vec2f& u);
float square_to_sphere_pdf(const Vec3f& w);

// Returns barycentric coordinates (b1, b2), with b0 = 1 - b1 - b2, that are uniform in area. The
// method is from Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
[[gnu::always_inline]] inline Vec2f square_to_triangle(const Vec2f& u) {
  const bool above = u.y > u.x;
  const float half = (above ? u.x : u.y) / 2, rest = (above ? u.y : u.x) - half;
  return above ? Vec2f(half, rest) : Vec2f(rest, half);
}

}  // namespace emberline
