// Makes lights for tests, and compares the irradiance that sampling estimates with the exact
// irradiance.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "renderer/core/moments.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_sampler.h"
#include "support/chi_square.h"
#include "support/closed_forms.h"
#include "support/single_queries.h"

namespace emberline::test {

using Triangles = std::vector<EmissiveTriangle>;

inline EmissiveTriangle triangle(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2,
                                 float radiance = 1.0f, bool two_sided = false) {
  EmissiveTriangle t;
  t.p0 = p0;
  t.p1 = p1;
  t.p2 = p2;
  t.mean_radiance = Rgb(radiance);
  t.two_sided = two_sided;
  return t;
}

inline void add_quad(Triangles& list, const Vec3f& a, const Vec3f& b, const Vec3f& c,
                     const Vec3f& d, float radiance = 1.0f) {
  list.push_back(triangle(a, b, c, radiance));
  list.push_back(triangle(a, c, d, radiance));
}

inline PointLight point_light(const Vec3f& position, float intensity) {
  PointLight light;
  light.position = position;
  light.intensity = Rgb(intensity);
  return light;
}

inline PointLight directional(const Vec3f& direction, float irradiance) {
  PointLight light;
  light.type = PointLightType::kDirectional;
  light.direction = normalize(direction);
  light.intensity = Rgb(irradiance);
  return light;
}

// Replaces a braced list, because GCC 12 prints a false warning for braced lists
// (-Wmaybe-uninitialized).
template <class... Points>
std::vector<PointLight> points_of(const Points&... points) {
  std::vector<PointLight> result;
  (result.push_back(points), ...);
  return result;
}

inline LightSampler make_light_sampler(
    Triangles triangles, std::vector<PointLight> points = {},
    std::shared_ptr<const EnvironmentLight> environment = nullptr, uint32_t threshold = 16) {
  return LightSampler(std::move(triangles), std::move(points), std::move(environment), nullptr,
                      threshold);
}

// Returns a sample's contribution to the irradiance at the query. Nothing occludes the light.
inline double irradiance_of(const LightSampler& lights, const LightQuery& query,
                            const LightSample& s) {
  if (s.kind == LightKind::kNone) return 0;
  double cosine = double(dot(query.normal, s.direction));
  if (query.both_sides) cosine = std::abs(cosine);
  const Rgb radiance =
      s.kind == LightKind::kTriangle ? lights.triangles()[s.index].mean_radiance : s.radiance;
  return double(luminance(radiance)) * std::max(0.0, cosine) / double(s.pdf);
}

inline Moments estimate(const LightSampler& lights, const LightQuery& query, int samples,
                        uint64_t seed) {
  Moments moments;
  for (int i = 0; i < samples; ++i) {
    TestRandom random(seed, uint64_t(i));
    const float pick = random.next();
    moments.add(irradiance_of(lights, query, test::sample_one(lights, query, pick, random.vec2())));
  }
  return moments;
}

// Expects that the sampled irradiance is `exact`. The tolerance of 5.5 standard errors keeps the
// probability of a false alarm below 1e-6 for all comparisons of a test together.
inline void expect_irradiance(const LightSampler& lights, const LightQuery& query, double exact,
                              const std::string& what, int samples = 50'000,
                              double relative = 1e-5) {
  const Moments m = estimate(lights, query, samples, 77);
  EXPECT_NEAR(m.mean(), exact, 5.5 * m.standard_error() + relative * exact)
      << what << ": replay with seed 77, standard error " << m.standard_error();
}

inline double exact_irradiance(const Triangles& triangles, const LightQuery& query) {
  double sum = 0;
  for (const EmissiveTriangle& t : triangles) {
    const Vec3d p0(t.p0), p1(t.p1), p2(t.p2), point(query.point);
    const bool front = dot(cross(p1 - p0, p2 - p0), point - p0) > 0;
    if (!front && !t.two_sided) continue;
    const double radiance = double(luminance(t.mean_radiance));
    sum += radiance * polygon_irradiance({p0, p1, p2}, point, Vec3d(query.normal));
    if (query.both_sides)
      sum += radiance * polygon_irradiance({p0, p1, p2}, point, -Vec3d(query.normal));
  }
  return sum;
}

// Returns the triangles of a sphere, which face outwards. Each of its `rings` rings has 2 * rings
// faces.
inline Triangles sphere(const Vec3f& centre, float radius, int rings, float radiance) {
  Triangles list;
  const auto at = [&](int i, int j) {
    const double theta = kPiD * i / rings, phi = kPiD * j / rings;
    return centre + Vec3f(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                          float(std::sin(theta) * std::sin(phi))) *
                        radius;
  };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < 2 * rings; ++j) {
      if (i > 0) list.push_back(triangle(at(i, j), at(i, j + 1), at(i + 1, j + 1), radiance));
      if (i + 1 < rings)
        list.push_back(triangle(at(i, j), at(i + 1, j + 1), at(i + 1, j), radiance));
    }
  return list;
}

}  // namespace emberline::test
