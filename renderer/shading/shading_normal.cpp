#include "renderer/shading/shading_normal.h"

namespace emberline {

Vec3f mapped_normal(const Vec3f& normal, const Vec4f& tangent, const Vec3f& map_normal) {
  const Vec3f t(tangent.x, tangent.y, tangent.z);
  const Vec3f b = cross(normal, t);
  const float sign = tangent.w < 0.0f ? -1.0f : 1.0f;
  const float b2 = dot(b, b), limit = 1e-12f * dot(t, t) * dot(normal, normal);
  if (!(b2 > limit)) {  // also for NaN
    const Vec3f unit = normalize_or(normal, Vec3f(0.0f));
    if (unit == Vec3f(0.0f)) return normal;
    return normalize_or(ShadingFrame::from_normal(unit).to_world(map_normal), unit);
  }
  const Vec3f along_t = t * map_normal.x;
  return normalize_or(fma(normal, map_normal.z, fma(b, sign * map_normal.y, along_t)), normal);
}

namespace {

// Returns the unit vector nearest to n, in the plane of ng and n, for which the reflection R of wo
// satisfies R.ng >= `floor`. Coordinates in that plane are (along x, along ng), where x is a unit
// vector orthogonal to ng. The projection (a, c) of wo onto the plane has the length r, and
// reflection about a normal in the plane keeps this length. So in the limiting case, R is
// (sqrt(r^2 - floor^2), floor), and the normal is the bisector of (a, c) and R.
Vec3f tilt(const Vec3f& ng, const Vec3f& n, const Vec3f& wo, float floor) {
  // Orthogonalise twice, because the first difference may cancel. Two passes are enough (Kahan).
  Vec3f across = fma(ng, -dot(n, ng), n);
  across = fma(ng, -dot(across, ng), across);
  const float length2 = dot(across, across);
  if (!(length2 > 1e-30f)) return ng;
  const Vec3f x = across * (1.0f / std::sqrt(length2));
  const float a = dot(wo, x), c = dot(wo, ng);
  const float rest = safe_sqrt(fma(a, a, (c - floor) * (c + floor)));  // sqrt(r^2 - floor^2)
  // a + rest, without cancellation when a < 0.
  const float sum = a >= 0.0f ? a + rest : (c - floor) * (c + floor) / (rest - a);
  return normalize_or(fma(x, sum, ng * (c + floor)), ng);
}

}  // namespace

SurfaceFrame make_surface_frame(const Vec3f& face_normal, const Vec3f& vertex_normal,
                                const Vec3f& shading_normal, const Vec3f& wo) {
  SurfaceFrame result;
  result.back_facing = dot(face_normal, wo) < 0.0f;
  const Vec3f ng = result.back_facing ? -face_normal : face_normal;
  Vec3f n = normalize_or(shading_normal, ng);
  if (dot(vertex_normal, ng) < 0.0f) n = -n;

  const float cos_o = dot(wo, ng);
  const float floor = std::min(0.9f * cos_o, 0.01f);
  const float cos_n = dot(n, ng), cos_no = dot(n, wo);
  const bool keeps_mirror_above = fma(2.0f * cos_no, cos_n, -cos_o) >= floor;  // R.ng
  if (!(cos_n > 0.0f && cos_no > 0.0f && keeps_mirror_above)) n = tilt(ng, n, wo, floor);

  result.geometric_normal = ng;
  result.shading = ShadingFrame::from_normal(n);
  return result;
}

}  // namespace emberline
