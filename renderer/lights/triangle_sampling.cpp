#include "renderer/lights/triangle_sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/constants.h"
#include "renderer/core/warps.h"

namespace emberline {
namespace {

[[gnu::always_inline]] inline double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }

[[gnu::always_inline]] inline Vec3d unit(const Vec3d& v) {
  const double l = length(v);
  return l > 0 ? v * (1.0 / l) : Vec3d(0.0);  // one division in place of three
}

// Solid angle of unit a, b, c. `volume` is |a . (b x c)|; the caller may know it better than from
// three vectors that are almost the same.
double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c, double volume) {
  return 2.0 * std::atan2(volume, 1.0 + dot(a, b) + dot(a, c) + dot(b, c));
}

// Direction in the spherical triangle. Arvo's formulas with the vertex angle's sine and cosine
// from the planes' normals and with 1 - cos in place of cos where that would cancel.
Vec3d sample_direction(const SeenTriangle& t, const Vec2f& u) {
  const Vec3d plane_ab = cross(t.a, t.b), plane_ac = cross(t.a, t.c);
  const double scale = 1.0 / (length(plane_ab) * length(plane_ac));
  const double cos_alpha = dot(plane_ab, plane_ac) * scale;
  const double sin_alpha = std::abs(dot(t.a, cross(t.b, t.c))) * scale;
  const Vec3d chord = t.b - t.a;
  const double one_minus_cos_c = 0.5 * dot(chord, chord);

  // The part of the triangle up to the arc from b to a point on the arc from a to c has the area
  // u.x of the whole; q is the cosine of the arc from a to that point.
  const double half = 0.5 * double(u.x) * t.solid_angle;
  const double sin_half = std::sin(half), cos_half = std::cos(half);
  const double sin_area = 2.0 * sin_half * cos_half, one_minus_cos_area = 2.0 * sin_half * sin_half;
  const double cos_area = 1.0 - one_minus_cos_area;
  const double s = fma(sin_area, cos_alpha, -(cos_area * sin_alpha));
  const double c = fma(cos_area, cos_alpha, sin_area * sin_alpha);
  // c - cos alpha, and s + sin alpha cos c.
  const double du = fma(sin_area, sin_alpha, -(one_minus_cos_area * cos_alpha));
  const double dv = fma(sin_area, cos_alpha, sin_alpha * (one_minus_cos_area - one_minus_cos_c));
  const double denominator = fma(dv, s, du * c) * sin_alpha;
  const double numerator = fma(fma(dv, c, -(du * s)), cos_alpha, -dv);
  const double q = denominator != 0 ? std::clamp(numerator / denominator, -1.0, 1.0) : 1.0;
  const Vec3d toward_c = unit(fma(t.a, -dot(t.c, t.a), t.c));
  const Vec3d end = fma(toward_c, std::sqrt(std::max(0.0, (1.0 - q) * (1.0 + q))), t.a * q);

  // Along the arc from b to that point, uniform in the height above b.
  const Vec3d end_chord = end - t.b;
  const double h = double(u.y) * 0.5 * dot(end_chord, end_chord);  // 1 - cos of the arc from b
  const Vec3d toward_end = unit(fma(t.b, -dot(end, t.b), end));
  return fma(toward_end, std::sqrt(std::max(0.0, h * (2.0 - h))), t.b * (1.0 - h));
}

// Barycentric weights of p1 and p2 where the ray along w meets the triangle's plane.
Vec2f intersect_plane(const SeenTriangle& t, const Vec3d& w) {
  const Vec3d p = cross(w, t.edge2);
  const double scale = 1.0 / dot(t.edge1, p);
  const Vec3d from_p0 = -t.to_p0;
  double b1 = dot(from_p0, p) * scale;
  double b2 = dot(w, cross(from_p0, t.edge1)) * scale;
  if (!(b1 >= 0)) b1 = 0;  // rounding, and 0 / 0 at a grazing sliver
  if (!(b2 >= 0)) b2 = 0;
  const double sum = b1 + b2;
  if (sum > 1) b1 /= sum, b2 /= sum;
  return {float(b1), float(b2)};
}

}  // namespace

SeenTriangle see_triangle(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2, const Vec3f& point) {
  SeenTriangle t;
  const Vec3d o(point);
  t.to_p0 = Vec3d(p0) - o;
  t.edge1 = Vec3d(p1) - Vec3d(p0);
  t.edge2 = Vec3d(p2) - Vec3d(p0);
  const Vec3d n = cross(t.edge1, t.edge2);
  const double twice_area = length(n);
  if (!(twice_area > 0)) return t;
  t.normal = n * (1.0 / twice_area);
  t.height = -dot(t.to_p0, t.normal);
  const Vec3d to_p1 = Vec3d(p1) - o, to_p2 = Vec3d(p2) - o;
  const double la = length(t.to_p0), lb = length(to_p1), lc = length(to_p2);
  if (!(la > 0 && lb > 0 && lc > 0)) return t;
  const double per_a = 1.0 / la, per_b = 1.0 / lb, per_c = 1.0 / lc;
  t.a = t.to_p0 * per_a;
  t.b = to_p1 * per_b;
  t.c = to_p2 * per_c;
  const double volume = std::abs(t.height) * per_a * (twice_area * per_b) * per_c;
  t.solid_angle = solid_angle(t.a, t.b, t.c, volume);
  if (t.solid_angle > 0) t.area = 0.5 * twice_area;
  return t;
}

float triangle_pdf(const SeenTriangle& t, float distance) {
  if (!(t.area > 0)) return 0.0f;
  if (t.spherical()) return float(1.0 / t.solid_angle);
  // |cos| at the light is height / distance, whatever direction a ray found it in.
  const double d = double(distance);
  const double pdf = d * d / t.area * (d / std::abs(t.height));
  return pdf < double(std::numeric_limits<float>::max()) ? float(pdf) : 0.0f;
}

TriangleSample sample_triangle(const SeenTriangle& t, const Vec3f& point, const Vec2f& u) {
  TriangleSample result;
  if (!(t.area > 0)) return result;
  result.barycentric =
      t.spherical() ? intersect_plane(t, sample_direction(t, u)) : square_to_triangle(u);
  const Vec3d to_light = fma(t.edge2, double(result.barycentric.y),
                             fma(t.edge1, double(result.barycentric.x), t.to_p0));
  const double distance = length(to_light);
  if (!(distance > 0)) return result;
  result.position = Vec3f(Vec3d(point) + to_light);
  result.direction = Vec3f(to_light * (1.0 / distance));
  result.distance = float(distance);
  result.pdf = triangle_pdf(t, result.distance);
  return result;
}

Vec2f spherical_triangle_to_square(const SeenTriangle& t, const Vec3d& w) {
  // Where the arc from b through w meets the arc from a to c.
  Vec3d end = unit(cross(cross(t.b, w), cross(t.c, t.a)));
  if (dot(end, t.a + t.c) < 0) end = -end;
  const double part = solid_angle(t.a, t.b, end, std::abs(dot(t.a, cross(t.b, end))));
  const Vec3d to_w = w - t.b, to_end = end - t.b;
  return {float(std::clamp(part / t.solid_angle, 0.0, 1.0)),
          float(std::clamp(dot(to_w, to_w) / dot(to_end, to_end), 0.0, 1.0))};
}

}  // namespace emberline
