#include "renderer/lights/triangle_sampling.h"

#include <cmath>
#include <limits>

#include "renderer/core/constants.h"
#include "renderer/core/warps.h"

namespace emberline {
namespace {

// The following functions are branch-free, so that loops over the samples of a batch vectorise.

[[gnu::always_inline]] inline double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }

// Returns 1 / x, or 0 for 0.
[[gnu::always_inline]] inline double reciprocal(double x) { return x > 0 ? 1.0 / x : 0.0; }

// Returns a vector along v with the squared length `length2`, which rounding may have made slightly
// negative.
[[gnu::always_inline]] inline Vec3d of_length2(const Vec3d& v, double length2) {
  const double scale2 = length2 * reciprocal(dot(v, v));
  return v * std::sqrt(scale2 > 0 ? scale2 : 0.0);
}

// Evaluates a polynomial by Horner's scheme; the coefficient of the highest power comes first.
template <class... Coefficients>
[[gnu::always_inline]] inline double polynomial(double x, double first, Coefficients... others) {
  double sum = first;
  ((sum = fma(sum, x, others)), ...);
  return sum;
}

// Computes std::atan2 for y >= 0 with a relative error of 1e-15. It uses our own Chebyshev fit of
// atan(z) / z over |z| <= tan(pi / 8).
[[gnu::always_inline]] inline double angle_of(double y, double x) {
  constexpr double kLargest = 0.41421356237309503;  // tan(pi / 8)
  const double ax = std::abs(x), smaller = y < ax ? y : ax, larger = y < ax ? ax : y;
  const bool reduce = smaller > kLargest * larger;
  const double numerator = reduce ? smaller - larger : smaller;
  const double z = numerator * reciprocal(reduce ? smaller + larger : larger);
  const double t = z * z;
  const double p = polynomial(t, -0.025316479573776474, 0.05024762118940128, -0.0650598296717084,
                              0.07673535428183285, -0.09089529956562307, 0.11111048853751296,
                              -0.14285712661684793, 0.19999999978392663, -0.3333333333322143);
  const double reduced = fma(z * t, p, z);
  const double eighth = reduce ? kPiD / 4 + reduced : reduced;
  const double quarter = y > ax ? kPiD / 2 - eighth : eighth;
  return x < 0 ? kPiD - quarter : quarter;
}

// Computes sine and cosine of x in [0, pi] from Taylor series of the half angle. The relative error
// of the sine is 1e-13.
[[gnu::always_inline]] inline void sincos_to_pi(double x, double* sine, double* cosine) {
  const double h = 0.5 * x, h2 = h * h;
  const double p = polynomial(h2, 1.0 / 355687428096000, -1.0 / 1307674368000, 1.0 / 6227020800,
                              -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6);
  const double s = fma(h * h2, p, h);
  const double c = polynomial(h2, 1.0 / 20922789888000, -1.0 / 87178291200, 1.0 / 479001600,
                              -1.0 / 3628800, 1.0 / 40320, -1.0 / 720, 1.0 / 24, -0.5, 1.0);
  *sine = 2.0 * s * c;
  *cosine = fma(-2.0 * s, s, 1.0);
}

// Returns the solid angle of the triangle between the unit vectors a, b, c. `volume` is |a . (b x
// c)|; the caller passes it, as it may know a more exact value if the vectors are nearly equal.
[[gnu::always_inline]] inline double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c,
                                                 double volume) {
  return 2.0 * angle_of(volume, 1.0 + dot(a, b) + dot(a, c) + dot(b, c));
}

[[gnu::always_inline]] inline ProjectedTriangle project(const Vec3f& p0, const Vec3f& p1,
                                                        const Vec3f& p2, const Vec3f& point) {
  ProjectedTriangle t;
  const Vec3d o = to_double(point), v0 = to_double(p0), v1 = to_double(p1), v2 = to_double(p2);
  t.to_p0 = v0 - o;
  t.edge1 = v1 - v0;
  t.edge2 = v2 - v0;
  const Vec3d n = cross(t.edge1, t.edge2);
  const double twice_area = length(n);
  t.normal = n * reciprocal(twice_area);
  t.height = -dot(t.to_p0, t.normal);
  const Vec3d to_p1 = v1 - o, to_p2 = v2 - o;
  const double per_a = reciprocal(length(t.to_p0)), per_b = reciprocal(length(to_p1)),
               per_c = reciprocal(length(to_p2));
  t.a = t.to_p0 * per_a;
  t.b = to_p1 * per_b;
  t.c = to_p2 * per_c;
  const double volume = std::abs(t.height) * per_a * (twice_area * per_b) * per_c;
  t.solid_angle = solid_angle(t.a, t.b, t.c, volume);
  t.area = volume > 0 && t.solid_angle > 0 ? 0.5 * twice_area : 0.0;
  return t;
}

// Samples a direction in the spherical triangle by Arvo's method, rearranged for precision. The
// angle alpha at vertex a comes from the normals of two planes. Arvo first chooses a point on the
// side from a to c, and computes the cosine of the arc from a to this point. The code computes 1
// minus this cosine instead, as (1 - cos area) (1 + cos ab) divided by a sum. Here `area` is the
// sampled part of the solid angle, and ab is the arc from a to b (`c` in the names below). The sum
// cancels only where the chosen point approaches vertex c. The result is accurate even if a and b
// are opposite, as they are when seen from the foot of a wall.
[[gnu::always_inline]] inline Vec3d sample_direction(const ProjectedTriangle& t, const Vec2f& u) {
  const Vec3d plane_ab = cross(t.a, t.b), plane_ac = cross(t.a, t.c);
  const double scale = reciprocal(std::sqrt(dot(plane_ab, plane_ab) * dot(plane_ac, plane_ac)));
  const double cos_alpha = dot(plane_ab, plane_ac) * scale;
  const double sin_alpha = std::abs(dot(t.a, cross(t.b, t.c))) * scale;
  const Vec3d chord = t.b - t.a;
  const double one_minus_cos_c = 0.5 * dot(chord, chord);

  const Vec3d opposite = t.b + t.a;
  const double one_plus_cos_c = 0.5 * dot(opposite, opposite);

  // Find the point `end` on the arc from a to c such that the arc from b to `end` cuts off the
  // fraction u.x of the area. h_c is 1 minus the cosine of the arc from a to `end`.
  double sin_half, cos_half;
  sincos_to_pi(0.5 * double(u.x) * t.solid_angle, &sin_half, &cos_half);
  const double sin_area = 2.0 * sin_half * cos_half, one_minus_cos_area = 2.0 * sin_half * sin_half;
  const double cos_area = 1.0 - one_minus_cos_area;
  const double sin_rest = fma(cos_area, sin_alpha, -(sin_area * cos_alpha));  // sin(alpha - area)
  const double ratio = one_minus_cos_area * one_plus_cos_c /
                       fma(one_minus_cos_c * sin_alpha, sin_rest, one_minus_cos_area);
  const Vec3d whole = t.c - t.a;
  const double limit = 0.5 * dot(whole, whole);
  const double some = ratio >= 0.0 ? ratio : limit;  // rounding next to c, or NaN from 0 / 0
  const double h_c = some < limit ? some : limit;
  const Vec3d toward_c = fma(t.a, -dot(t.c, t.a), t.c);
  const Vec3d end = of_length2(toward_c, h_c * (2.0 - h_c)) + t.a * (1.0 - h_c);

  // Choose a point on the arc from b to `end`, uniformly in h.
  const Vec3d end_chord = end - t.b;
  const double h = double(u.y) * 0.5 * dot(end_chord, end_chord);  // 1 - cos of the arc from b
  const Vec3d toward_end = fma(t.b, -dot(end, t.b), end);
  return of_length2(toward_end, h * (2.0 - h)) + t.b * (1.0 - h);
}

// Returns the barycentric weights of p1 and p2 at which the ray along w intersects the triangle's
// plane.
[[gnu::always_inline]] inline Imath::Vec2<double> intersect_plane(const ProjectedTriangle& t,
                                                                  const Vec3d& w) {
  const Vec3d p = cross(w, t.edge2);
  const double scale = 1.0 / dot(t.edge1, p);
  const Vec3d from_p0 = -t.to_p0;
  double b1 = dot(from_p0, p) * scale;
  double b2 = dot(w, cross(from_p0, t.edge1)) * scale;
  b1 = b1 >= 0 ? b1 : 0.0;  // rounding errors, or 0 / 0 for a grazing sliver
  b2 = b2 >= 0 ? b2 : 0.0;
  b1 = b1 <= 1 ? b1 : 1.0;
  b2 = b2 <= 1 - b1 ? b2 : 1 - b1;
  return {b1, b2};
}

[[gnu::always_inline]] inline float density(const ProjectedTriangle& t, float distance) {
  // Whatever the ray's direction, |cos| at the light is |height| / distance.
  const double d = double(distance);
  const bool spherical = t.spherical();
  const double numerator = spherical ? 1.0 : d * d * d;
  const double pdf = numerator / (spherical ? t.solid_angle : t.area * std::abs(t.height));
  return t.area > 0 && pdf < double(std::numeric_limits<float>::max()) ? float(pdf) : 0.0f;
}

[[gnu::always_inline]] inline TriangleSample sample(const ProjectedTriangle& t, const Vec3f& point,
                                                    const Vec2f& u) {
  TriangleSample result;
  const Imath::Vec2<double> by_direction = intersect_plane(t, sample_direction(t, u));
  const Vec2f by_area = square_to_triangle(u);
  const bool spherical = t.spherical();
  // Keep the weights in double. If the point is closer to the triangle than the spacing of floats
  // along its edges, rounded weights would change the direction.
  const double b1 = spherical ? by_direction.x : double(by_area.x);
  const double b2 = spherical ? by_direction.y : double(by_area.y);
  result.barycentric = {float(b1), float(b2)};
  const Vec3d to_light = fma(t.edge2, b2, fma(t.edge1, b1, t.to_p0));
  const double distance = length(to_light);
  result.position = to_float(to_double(point) + to_light);
  result.direction = to_float(to_light * reciprocal(distance));
  result.distance = float(distance);
  result.pdf = distance > 0 ? density(t, result.distance) : 0.0f;
  return result;
}

}  // namespace

ProjectedTriangle project_triangle(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2,
                                   const Vec3f& point) {
  return project(p0, p1, p2, point);
}

float triangle_pdf(const ProjectedTriangle& t, float distance) { return density(t, distance); }

void TriangleBatch::add(const std::array<Vec3f, 3>& corners, const Vec3f& point, const Vec2f& u) {
  const int i = count_++;
  for (int v = 0; v < 3; ++v) {
    for (int c = 0; c < 3; ++c) corners_[v][c][i] = corners[size_t(v)][c];
    point_[v][i] = point[v];
  }
  u_[0][i] = u.x;
  u_[1][i] = u.y;
}

[[gnu::always_inline]] inline void TriangleBatch::evaluate(int i) {
  const auto vector = [i](const Lanes(&lanes)[3]) {
    return Vec3f(lanes[0][i], lanes[1][i], lanes[2][i]);
  };
  const auto put = [i](const Vec3f& v, Lanes(&lanes)[3]) {
    lanes[0][i] = v.x;
    lanes[1][i] = v.y;
    lanes[2][i] = v.z;
  };
  const Vec3f point = vector(point_);
  const ProjectedTriangle projected =
      project(vector(corners_[0]), vector(corners_[1]), vector(corners_[2]), point);
  const TriangleSample s = emberline::sample(projected, point, {u_[0][i], u_[1][i]});
  barycentric_[0][i] = s.barycentric.x;
  barycentric_[1][i] = s.barycentric.y;
  put(s.position, position_);
  put(s.direction, direction_);
  put(to_float(projected.normal), normal_);
  distance_[i] = s.distance;
  pdf_[i] = s.pdf;
  height_[i] = projected.height;
}

[[gnu::noinline]] void TriangleBatch::evaluate_single(int i) { evaluate(i); }

void TriangleBatch::sample() {
  // Samples are computed in groups of four. If one or two remain, it is faster to compute them one
  // by one; three are padded to a group.
  const int over = count_ % 4, lanes = over == 3 ? count_ + 1 : count_ - over;
  if (over == 3) {
    for (int c = 0; c < 3; ++c) {
      for (Lanes(&corner)[3] : corners_) corner[c][count_] = corner[c][0];
      point_[c][count_] = point_[c][0];
    }
    for (Lanes& u : u_) u[count_] = u[0];
  }
  for (int i = 0; i < lanes; ++i) evaluate(i);
  for (int i = lanes; i < count_; ++i) evaluate_single(i);
}

}  // namespace emberline
