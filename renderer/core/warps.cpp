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

float square_to_disk_pdf(const Vec2f& p) { return p.dot(p) <= 1.0f ? kInvPi : 0.0f; }

Vec2f disk_to_square(const Vec2f& p) {
  const float r = std::sqrt(p.dot(p));
  float phi = std::atan2(p.y, p.x);
  if (phi < -kPi / 4) phi += 2 * kPi;  // [-pi/4, 7pi/4): the four wedges in a row
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

Vec3f square_to_cosine_hemisphere(const Vec2f& u) {
  const Vec2f d = square_to_disk(u);
  // 1 - |d|^2 rounds to 0 on the rim; a direction with z = 0 has density 0, so keep z positive.
  return {d.x, d.y, std::sqrt(std::max(1e-12f, 1.0f - d.dot(d)))};
}

float square_to_cosine_hemisphere_pdf(const Vec3f& w) { return std::max(0.0f, w.z) * kInvPi; }

Vec2f cosine_hemisphere_to_square(const Vec3f& w) { return disk_to_square({w.x, w.y}); }

Vec3f square_to_sphere(const Vec2f& u) {
  const float z = 1.0f - 2.0f * u.x;
  const float r = 2.0f * safe_sqrt(u.x * (1.0f - u.x));  // sqrt(1 - z^2) without cancellation
  const float phi = 2.0f * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

float square_to_sphere_pdf(const Vec3f&) { return 1.0f / (4.0f * kPi); }

Vec2f sphere_to_square(const Vec3f& w) {
  float phi = std::atan2(w.y, w.x);
  if (phi < 0) phi += 2 * kPi;
  return {(1.0f - w.z) / 2, phi / (2 * kPi)};
}

Vec2f triangle_to_square(const Vec2f& b) {
  if (b.y > b.x) return {2 * b.x, b.y + b.x};
  return {b.x + b.y, 2 * b.y};
}

}  // namespace emberline
