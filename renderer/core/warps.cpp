#include "renderer/core/warps.h"

namespace emberline {

Vec2f square_to_disk(const Vec2f& u) {
  const float a = 2.0f * u.x - 1.0f;
  const float b = 2.0f * u.y - 1.0f;
  if (a == 0.0f && b == 0.0f) return {0.0f, 0.0f};
  float r, phi;
  if (std::abs(a) > std::abs(b)) {
    r = a;
    phi = (kPi / 4) * (b / a);
  } else {
    r = b;
    phi = (kPi / 2) - (kPi / 4) * (a / b);
  }
  return {r * std::cos(phi), r * std::sin(phi)};
}

Vec3f square_to_cosine_hemisphere(const Vec2f& u) {
  const Vec2f d = square_to_disk(u);
  // On the rim of the disk, 1 - |d|^2 may round to 0. Keep z positive, because the density at z = 0
  // is 0.
  return {d.x, d.y, std::sqrt(std::max(1e-12f, 1.0f - d.dot(d)))};
}

Vec3f square_to_sphere(const Vec2f& u) {
  const float z = 1.0f - 2.0f * u.x;
  const float r = 2.0f * safe_sqrt(u.x * (1.0f - u.x));  // sqrt(1 - z^2) without cancellation
  const float phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

float square_to_sphere_pdf(const Vec3f&) { return 1.0f / (4.0f * kPi); }

}  // namespace emberline
