// The choice among all lights: frequencies, densities, and irradiance in closed form.
#include "renderer/lights/light_sampler.h"

#include <gtest/gtest.h>

#include <map>

#include "renderer/core/moments.h"
#include "renderer/core/ray.h"
#include "renderer/core/warps.h"
#include "renderer/lights/environment_light.h"
#include "support/chi_square.h"
#include "support/closed_forms.h"

namespace emberline {
namespace {

using test::TestRandom;
using Triangles = std::vector<EmissiveTriangle>;

EmissiveTriangle triangle(const Vec3f& p0, const Vec3f& p1, const Vec3f& p2, float radiance = 1.0f,
                          bool two_sided = false) {
  EmissiveTriangle t;
  t.p0 = p0;
  t.p1 = p1;
  t.p2 = p2;
  t.mean_radiance = Rgb(radiance);
  t.two_sided = two_sided;
  return t;
}

void add_quad(Triangles& list, const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d,
              float radiance = 1.0f) {
  list.push_back(triangle(a, b, c, radiance));
  list.push_back(triangle(a, c, d, radiance));
}

PointLight point_light(const Vec3f& position, float intensity) {
  PointLight light;
  light.position = position;
  light.intensity = Rgb(intensity);
  return light;
}

PointLight directional(const Vec3f& direction, float irradiance) {
  PointLight light;
  light.type = PointLightType::kDirectional;
  light.direction = normalize(direction);
  light.intensity = Rgb(irradiance);
  return light;
}

// A braced list of them would do, but for a false warning of GCC 12 (-Wmaybe-uninitialized).
template <class... Points>
std::vector<PointLight> points_of(const Points&... points) {
  std::vector<PointLight> result;
  (result.push_back(points), ...);
  return result;
}

LightSampler make(Triangles triangles, std::vector<PointLight> points = {},
                  std::shared_ptr<const EnvironmentLight> environment = nullptr,
                  uint32_t threshold = 16) {
  return LightSampler(std::move(triangles), std::move(points), std::move(environment), {threshold});
}

// What a sample adds to the irradiance at the query: nothing occludes.
double irradiance_of(const LightSampler& lights, const LightQuery& query, const LightSample& s) {
  if (s.kind == LightKind::kNone) return 0;
  double cosine = double(dot(query.normal, s.direction));
  if (query.both_sides) cosine = std::abs(cosine);
  const Rgb radiance =
      s.kind == LightKind::kTriangle ? lights.triangles()[s.index].mean_radiance : s.radiance;
  return double(luminance(radiance)) * std::max(0.0, cosine) / double(s.pdf);
}

Moments estimate(const LightSampler& lights, const LightQuery& query, int samples, uint64_t seed) {
  Moments moments;
  for (int i = 0; i < samples; ++i) {
    TestRandom random(seed, uint64_t(i));
    const float pick = random.next();
    moments.add(irradiance_of(lights, query, lights.sample(query, pick, random.vec2())));
  }
  return moments;
}

// 5.5 deviations: below 1e-6 for the comparisons of one test together.
void expect_irradiance(const LightSampler& lights, const LightQuery& query, double exact,
                       const std::string& what, int samples = 50'000, double relative = 1e-5) {
  const Moments m = estimate(lights, query, samples, 77);
  EXPECT_NEAR(m.mean(), exact, 5.5 * m.standard_error() + relative * exact)
      << what << ": replay with TestRandom(77, draw), standard error " << m.standard_error();
}

double exact_irradiance(const Triangles& triangles, const LightQuery& query) {
  double sum = 0;
  for (const EmissiveTriangle& t : triangles) {
    const Vec3d p0(t.p0), p1(t.p1), p2(t.p2), point(query.point);
    const bool front = dot(cross(p1 - p0, p2 - p0), point - p0) > 0;
    if (!front && !t.two_sided) continue;
    const double radiance = double(luminance(t.mean_radiance));
    sum += radiance * test::polygon_irradiance({p0, p1, p2}, point, Vec3d(query.normal));
    if (query.both_sides)
      sum += radiance * test::polygon_irradiance({p0, p1, p2}, point, -Vec3d(query.normal));
  }
  return sum;
}

// A sphere of 2 * rings * rings triangles, facing out.
Triangles sphere(const Vec3f& centre, float radius, int rings, float radiance) {
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

// ---- closed forms ------------------------------------------------------------------------------

TEST(LightSampler, Rectangle) {
  Triangles quad;  // faces down to a receiver below its inside: algorithms' case 6
  add_quad(quad, {-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f});
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  EXPECT_NEAR(exact_irradiance(quad, query), 0.683537, 1e-6);
  for (uint32_t threshold : {1u, 16u})
    expect_irradiance(make(quad, {}, nullptr, threshold), query, 0.683537, "threshold", 50'000,
                      1e-5);
  // From behind there is nothing; a two-sided one shines there too.
  const LightQuery behind{Vec3f(0, 2.4f, 0), Vec3f(0, -1, 0)};
  EXPECT_EQ(estimate(make(quad), behind, 1000, 1).mean(), 0);
  for (EmissiveTriangle& t : quad) t.two_sided = true;
  expect_irradiance(make(quad), behind, 0.683537, "two-sided, behind");
}

TEST(LightSampler, HorizonCutsARectangle) {
  Triangles quad;
  add_quad(quad, {1, -1, -1}, {1, -1, 1}, {1, 1.5f, 1}, {1, 1.5f, -1});
  for (const Vec3f& n :
       {Vec3f(0, 1, 0), normalize(Vec3f(1, 1, 0.3f)), normalize(Vec3f(-1, 2, 0))}) {
    LightQuery query{Vec3f(0.0f), n};
    expect_irradiance(make(quad), query, exact_irradiance(quad, query), "cut");
    query.both_sides = true;
    expect_irradiance(make(quad), query, exact_irradiance(quad, query), "both sides");
  }
}

TEST(LightSampler, TessellatedSphere) {
  // Case 7: the smooth sphere would give pi (R/d)^2 cos; the polygons have their own exact sum.
  const Triangles ball = sphere(Vec3f(0.5f, 2, 0.6f) * 3.0f, 1.0f, 16, 2.0f);
  ASSERT_EQ(ball.size(), 2u * 16 * 2 * 15);
  for (const Vec3f& n :
       {Vec3f(0, 1, 0), normalize(Vec3f(1, 0.1f, 0)), normalize(Vec3f(1, -0.25f, 0.1f))}) {
    const LightQuery query{Vec3f(0.0f), n};
    const double exact = exact_irradiance(ball, query);
    if (n == Vec3f(0, 1, 0)) {
      const double d2 = 9 * (0.25 + 4 + 0.36);
      EXPECT_NEAR(exact, 2 * kPiD / d2 * 6 / std::sqrt(d2), 0.02 * exact);
    }
    expect_irradiance(make(ball), query, exact, "sphere, light BVH");
    expect_irradiance(make(ball, {}, nullptr, 1u << 20), query, exact, "sphere, power", 200'000);
  }
}

TEST(LightSampler, SunSizedDisc) {
  for (double half_angle : {0.00465, 1e-4}) {  // case 9
    Triangles disc;
    const Vec3d axis = test::unit(Vec3d(1, 2, 0.5)), u = test::unit(cross(axis, Vec3d(0, 1, 0)));
    const Vec3d v = cross(u, axis);
    const auto rim = [&](int i) {
      const double phi = 2 * kPiD * i / 64;
      return Vec3f((axis + (u * std::cos(phi) + v * std::sin(phi)) * std::tan(half_angle)) * 1e4);
    };
    for (int i = 0; i < 64; ++i)
      disc.push_back(triangle(Vec3f(axis * 1e4), rim(i), rim(i + 1), 1e4f, true));
    const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
    const double exact = exact_irradiance(disc, query);
    const double sine = std::sin(half_angle);
    EXPECT_NEAR(exact, 1e4 * kPiD * sine * sine * axis.y, 0.003 * exact);  // 64-gon, not a circle
    expect_irradiance(make(disc), query, exact, "disc");
  }
}

TEST(LightSampler, PointAndSpot) {
  const Vec3f position(1, 2, -2);  // distance 3
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  expect_irradiance(make({}, points_of(point_light(position, 5))), query, 5 * (2.0 / 3) / 9,
                    "point", 100);

  PointLight spot = point_light(position, 5);
  spot.type = PointLightType::kSpot;
  const double cosine = 0.8;  // between the axis and the way to the query
  const Vec3f down = normalize(-position), side = normalize(cross(down, Vec3f(0, 1, 0)));
  spot.direction = down * float(cosine) + side * float(std::sqrt(1 - cosine * cosine));
  struct Cone {
    float inner, outer;
    double attenuation;
  };
  for (const Cone& c :
       {Cone{0.75f, 0.5f, 1.0}, Cone{0.95f, 0.9f, 0.0}, Cone{0.9f, 0.7f, 0.25},
        Cone{0.85f, 0.75f, 0.25}, Cone{0.81f, 0.81f, 0.0}, Cone{0.79f, 0.79f, 1.0}}) {
    spot.cos_inner = c.inner;
    spot.cos_outer = c.outer;
    for (uint32_t threshold : {1u, 16u})
      expect_irradiance(make({}, points_of(spot), nullptr, threshold), query,
                        5 * (2.0 / 3) / 9 * c.attenuation, "spot", 100, 1e-4);
  }
}

TEST(LightSampler, PointPowerThroughAClosedBox) {
  // Case 10: the flux of a point of intensity 2 through any closed surface around it is 8 pi.
  Moments flux;
  for (uint64_t draw = 0; draw < 200'000; ++draw) {
    TestRandom random(5, draw);
    const int side = int(random.bits() % 6);
    Vec3f at(random.next() * 2 - 1, random.next() * 2 - 1, random.next() * 2 - 1), n(0.0f);
    at[side / 2] = side & 1 ? 1.0f : -1.0f;
    n[side / 2] = -at[side / 2];
    static const LightSampler lights = make({}, points_of(point_light({0.3f, -0.2f, 0.1f}, 2)));
    const LightQuery query{at, n};
    flux.add(24 * irradiance_of(lights, query, lights.sample(query, random.next(), random.vec2())));
  }
  EXPECT_NEAR(flux.mean(), 8 * kPiD, 4.9 * flux.standard_error());
}

// Inside a closed box of emitters the irradiance is pi everywhere, wherever one stands.
TEST(LightSampler, InsideAnEmittingBox) {
  for (float scale : {1e-6f, 1.0f, 1e6f}) {
    Triangles box;
    for (int axis = 0; axis < 3; ++axis)
      for (float s : {-1.0f, 1.0f}) {
        Vec3f c(0.0f), u(0.0f), v(0.0f);
        c[axis] = s * scale;
        u[(axis + 1) % 3] = scale;
        v[(axis + 2) % 3] = -s * scale;
        add_quad(box, c - u - v, c + u - v, c + u + v, c - u + v);
      }
    for (const Vec3f& p : {Vec3f(0.0f), Vec3f(0.99f, 0.5f, -0.2f), Vec3f(-0.999f, -0.999f, 0.999f)})
      for (uint32_t threshold : {1u, 16u}) {
        const LightQuery query{p * scale, normalize(Vec3f(0.3f, 0.5f, -0.8f))};
        expect_irradiance(make(box, {}, nullptr, threshold), query, kPiD, "box", 100'000);
      }
  }
}

TEST(LightSampler, InfiniteAndFiniteTogether) {
  Triangles quad;
  add_quad(quad, {-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f}, 3.0f);
  const auto sky = std::make_shared<EnvironmentLight>(Rgb(0.5f));
  const std::vector<PointLight> points =
      points_of(point_light({0, 2, 0}, 4), directional({0, -1, 0}, 2), directional({0, -1, 3}, 5),
                directional({0, 1, 0.2f}, 50));  // the last one from below
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  const double exact = 3 * 0.683537 + 0.5 * kPiD + 1 + 2 + 5 / std::sqrt(10.0);
  for (uint32_t threshold : {1u, 16u})
    expect_irradiance(make(quad, points, sky, threshold), query, exact, "all", 200'000);
  LightQuery both = query;
  both.both_sides = true;
  expect_irradiance(make(quad, points, sky), both, exact + 0.5 * kPiD + 50 / std::sqrt(1.04),
                    "both", 200'000);
}

// ---- many lamps
// ----------------------------------------------------------------------------------

Triangles lamps(int count, uint64_t seed) {
  Triangles list;
  for (int i = 0; i < count; ++i) {
    TestRandom random(seed, uint64_t(i));
    const Vec3f at(random.next() * 100 - 50, 2 + random.next(), random.next() * 100 - 50);
    add_quad(list, at, at + Vec3f(0.2f, 0, 0), at + Vec3f(0.2f, 0, 0.2f), at + Vec3f(0, 0, 0.2f),
             1 + 9 * random.next());
  }
  return list;
}

TEST(LightSampler, TenThousandLamps) {  // case 32
  const Triangles all = lamps(10'000, 20);
  const LightSampler tree = make(all), power = make(all, {}, nullptr, 1u << 30);
  EXPECT_EQ(tree.describe(), "light BVH (20000 emitters)");
  for (const Vec3f& p : {Vec3f(0.0f), Vec3f(30, 0, -45), Vec3f(-200, 0, 10)}) {
    const LightQuery query{p, Vec3f(0, 1, 0)};
    const double exact = exact_irradiance(all, query);
    expect_irradiance(tree, query, exact, "all lamps", 100'000);
    const double ratio = estimate(power, query, 100'000, 3).variance() /
                         estimate(tree, query, 100'000, 3).variance();
    if (p.x > -100) {
      EXPECT_GT(ratio, 30) << "the tree must be worth having";
    }
    // One of them is visible: the fifth nearest.
    std::vector<uint32_t> order(10'000);
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return (all[2 * a].p0 - p).length2() < (all[2 * b].p0 - p).length2();
    });
    const uint32_t visible = order[4];
    Moments one;
    for (int i = 0; i < 400'000; ++i) {
      TestRandom random(21, uint64_t(i));
      const float pick = random.next();
      const LightSample s = tree.sample(query, pick, random.vec2());
      one.add(s.kind == LightKind::kTriangle && s.index / 2 == visible
                  ? irradiance_of(tree, query, s)
                  : 0.0);
    }
    const double lamp = exact_irradiance({all[2 * visible], all[2 * visible + 1]}, query);
    EXPECT_NEAR(one.mean(), lamp, 5.5 * one.standard_error()) << "one visible lamp";
    EXPECT_LT(one.standard_error(), 0.1 * lamp);
  }
}

TEST(LightSampler, TwoLampsAtOneToTenThousand) {
  for (uint32_t threshold : {1u, 16u}) {
    Triangles two;
    add_quad(two, {0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1});
    add_quad(two, {1e4f, 1e4f, 0}, {1e4f + 1, 1e4f, 0}, {1e4f + 1, 1e4f, 1}, {1e4f, 1e4f, 1});
    const LightSampler lights = make(two, {}, nullptr, threshold);
    const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
    expect_irradiance(lights, query, exact_irradiance(two, query), "near and far");
    // The far one alone, seen among the samples of both.
    Moments far;
    for (int i = 0; i < 200'000; ++i) {
      // As dense a stratification as the tree's least probability asks for.
      const float pick = (float(i) + 0.5f) / 200'000;
      const LightSample s = lights.sample(query, pick, TestRandom(31, uint64_t(i)).vec2());
      if (s.kind == LightKind::kTriangle && s.index >= 2) far.add(irradiance_of(lights, query, s));
    }
    for (uint32_t index : {2u, 3u}) {
      const Vec3f to = two[index].p0 - query.point;
      EXPECT_GT(lights.pdf_triangle(query, index, normalize(to), to.length()), 0);
    }
    if (threshold == 16) {
      EXPECT_NEAR(double(far.count()) / 200'000, 0.5, 1e-3);
    }
  }
}

// ---- densities
// -----------------------------------------------------------------------------------

struct MixedScene {
  Triangles triangles;
  std::vector<PointLight> points;
  std::shared_ptr<const EnvironmentLight> sky = std::make_shared<EnvironmentLight>(Rgb(0.2f));
};

MixedScene mixed_scene(int count, float scale) {
  MixedScene scene;
  for (int i = 0; i < count; ++i) {
    TestRandom random(40, uint64_t(i));
    const auto point = [&random] {
      return Vec3f(random.next() * 2 - 1, random.next() * 2 - 1, random.next() * 2 - 1);
    };
    const Vec3f at = point() * 2.0f;
    scene.triangles.push_back(triangle(at * scale, (at + point()) * scale, (at + point()) * scale,
                                       random.next() + 0.1f, random.next() < 0.3f));
    if (i % 8 == 0) scene.points.push_back(point_light(point() * scale, scale * scale));
  }
  scene.points.push_back(directional({0.2f, -1, 0.1f}, 1));
  return scene;
}

TEST(LightSampler, SampleAndHitAgreeToTheBit) {
  for (float scale : {1e-6f, 1.0f, 1e6f})
    for (int count : {4, 200}) {
      const MixedScene scene = mixed_scene(count, scale);
      const LightSampler lights = make(scene.triangles, scene.points, scene.sky);
      int seen = 0;
      for (uint64_t draw = 0; draw < 5000; ++draw) {
        TestRandom random(41, draw);
        const LightQuery query{square_to_sphere(random.vec2()) * (3 * random.next() * scale),
                               square_to_sphere(random.vec2()), random.next() < 0.3f};
        const float pick = random.next();
        const LightSample s = lights.sample(query, pick, random.vec2());
        if (s.kind == LightKind::kNone) continue;
        ASSERT_GT(s.pdf, 0);
        ASSERT_TRUE(std::isfinite(s.pdf) && is_finite(s.radiance) && is_finite(s.direction));
        if (s.kind == LightKind::kEnvironment) {
          ASSERT_EQ(s.pdf, lights.pdf_environment(query, s.direction));
        }
        if (s.kind != LightKind::kTriangle) continue;
        ++seen;
        ASSERT_EQ(s.pdf, lights.pdf_triangle(query, s.index, s.direction, s.distance));
        // The position, barycentrics, direction and distance are one and the same point.
        const EmissiveTriangle& t = lights.triangles()[s.index];
        const Vec3f at = t.p0 * (1 - s.barycentric.x - s.barycentric.y) + t.p1 * s.barycentric.x +
                         t.p2 * s.barycentric.y;
        ASSERT_LT((at - s.position).length(), 1e-5f * scale);
        ASSERT_LT((query.point + s.direction * s.distance - s.position).length(), 1e-5f * scale);
        ASSERT_NEAR(dot(s.emitter_normal, s.emitter_normal), 1, 1e-5f);
        if (!t.two_sided) {
          ASSERT_LT(dot(s.emitter_normal, s.direction), 1e-6f);
        }
      }
      EXPECT_GT(seen, 400);
    }
}

// Over uniform directions, the densities of all triangles that a ray meets add up to the
// probability of sampling a triangle at all; points and environment are the rest.
TEST(LightSampler, DensitiesAddUpToOne) {
  const MixedScene scene = mixed_scene(30, 1.0f);
  for (uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights = make(scene.triangles, scene.points, scene.sky, threshold);
    for (uint64_t q = 0; q < 4; ++q) {
      TestRandom first(50, q);
      const LightQuery query{square_to_sphere(first.vec2()) * (2 * first.next()),
                             square_to_sphere(first.vec2()), q == 3};
      Moments integral, sampled;
      for (uint64_t draw = 0; draw < 100'000; ++draw) {
        TestRandom random(51, draw);
        const Vec3f w = square_to_sphere(random.vec2());
        double sum = double(lights.pdf_environment(query, w));
        for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
          const EmissiveTriangle& t = scene.triangles[i];
          const Vec3d e1 = Vec3d(t.p1) - Vec3d(t.p0), e2 = Vec3d(t.p2) - Vec3d(t.p0);
          const Vec3d d(w), s = Vec3d(query.point) - Vec3d(t.p0), p = cross(d, e2);
          const double det = dot(e1, p), b1 = dot(s, p) / det, b2 = dot(d, cross(s, e1)) / det;
          const double distance = dot(e2, cross(s, e1)) / det;
          if (b1 >= 0 && b2 >= 0 && b1 + b2 <= 1 && distance > 0)
            sum += double(lights.pdf_triangle(query, i, w, float(distance)));
        }
        integral.add(sum * 4 * kPiD);
        const float pick = random.next();
        const LightSample s = lights.sample(query, pick, random.vec2());
        sampled.add(s.kind == LightKind::kTriangle || s.kind == LightKind::kEnvironment ? 1.0
                                                                                        : 0.0);
      }
      const double error = std::hypot(integral.standard_error(), sampled.standard_error());
      EXPECT_NEAR(integral.mean(), sampled.mean(), 5.5 * error) << q << " threshold " << threshold;
      EXPECT_GT(integral.mean(), 0.3);
    }
  }
}

// Frequencies of the picks against the probabilities that the samples state: chi-square.
TEST(LightSampler, PicksAreAsFrequentAsStated) {
  const MixedScene scene = mixed_scene(40, 1.0f);
  for (uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights = make(scene.triangles, scene.points, scene.sky, threshold);
    const LightQuery query{Vec3f(0.1f, -0.3f, 0.5f), Vec3f(0, 1, 0), true};
    const int kSamples = 400'000;
    std::map<std::pair<int, uint32_t>, std::pair<double, int>> bins;  // probability, count
    for (int i = 0; i < kSamples; ++i) {
      TestRandom random(60, uint64_t(i));
      const float pick = random.next();
      const LightSample s = lights.sample(query, pick, random.vec2());
      if (s.kind == LightKind::kNone) continue;
      auto& [probability, count] = bins[{int(s.kind), s.index}];
      probability = double(s.pdf);
      // Divide the shape's own density away: a triangle's is what a lone one has.
      if (s.kind == LightKind::kTriangle)
        probability /= double(
            make({lights.triangles()[s.index]}).pdf_triangle(query, 0, s.direction, s.distance));
      if (s.kind == LightKind::kEnvironment) probability *= 4 * kPiD;
      ++count;
    }
    double statistic = 0, rest = 1;
    int degrees = 0, counted = 0;
    for (const auto& [light, bin] : bins) {
      if (bin.first * kSamples < 5) continue;
      statistic += square(bin.second - bin.first * kSamples) / (bin.first * kSamples);
      rest -= bin.first;
      counted += bin.second;
      ++degrees;
    }
    if (rest * kSamples >= 5) {
      statistic += square(kSamples - counted - rest * kSamples) / (rest * kSamples);
    } else {
      --degrees;
    }
    EXPECT_GT(degrees, 20);
    EXPECT_GT(test::chi_square_p_value(statistic, degrees), 5e-7) << statistic << " " << degrees;
  }
}

// ---- what must not be sampled ------------------------------------------------------------------

TEST(LightSampler, BrokenEmittersAreNeverSampled) {
  const float nan = std::nanf(""), inf = kInfinity;
  Triangles list = {triangle({0, 1, 0}, {0, 1, 0}, {1, 1, 0}),     // no area
                    triangle({0, 1, 0}, {1, 1, 0}, {2, 1, 0}),     // a line
                    triangle({0, nan, 0}, {1, 1, 0}, {2, 1, 3}),   //
                    triangle({0, 1, 0}, {inf, 1, 0}, {2, 1, 3}),   //
                    triangle({0, 1, 0}, {0, 1, 1}, {1, 1, 0}, 0),  // black
                    triangle({0, 1, 0}, {0, 1, 1}, {1, 1, 0}, nan)};
  const std::vector<PointLight> points =
      points_of(point_light({0, nan, 0}, 1), point_light({0, 1, 0}, 0), directional({0, -1, 0}, 0));
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  const LightSampler broken = make(list, points, std::make_shared<EnvironmentLight>(Rgb(0.0f)));
  EXPECT_TRUE(broken.empty());
  EXPECT_EQ(broken.describe(), "none");
  EXPECT_EQ(broken.environment(), nullptr);
  EXPECT_EQ(broken.sample(query, 0.5f, {0.5f, 0.5f}).kind, LightKind::kNone);
  EXPECT_EQ(broken.pdf_environment(query, {0, 1, 0}), 0);

  const uint32_t good = uint32_t(list.size());
  add_quad(list, {-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f});
  for (uint32_t threshold : {1u, 16u}) {
    const LightSampler lights = make(list, points, nullptr, threshold);
    EXPECT_FALSE(lights.empty());
    for (uint32_t i = 0; i < good; ++i)
      EXPECT_EQ(lights.pdf_triangle(query, i, Vec3f(0, 1, 0), 1.0f), 0);
    for (uint64_t draw = 0; draw < 2000; ++draw) {
      TestRandom random(70, draw);
      const LightSample s = lights.sample(query, random.next(), random.vec2());
      ASSERT_EQ(s.kind, LightKind::kTriangle);
      ASSERT_GE(s.index, good);
    }
    expect_irradiance(lights, query, 0.683537, "with broken company");
  }
}

// Everything at the edges of the random numbers, with the query where it hurts.
TEST(LightSampler, NothingIsEverNotANumber) {
  const MixedScene scene = mixed_scene(60, 1.0f);
  for (uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights = make(scene.triangles, scene.points, scene.sky, threshold);
    for (const EmissiveTriangle& t : scene.triangles)
      for (const Vec3f& p : {t.p0, (t.p0 + t.p1) * 0.5f, (t.p0 + t.p1 + t.p2) * (1 / 3.0f),
                             t.p0 * 2.0f - t.p1, t.p0 * 1e6f, scene.points[0].position})
        for (float pick : {0.0f, 0.5f, kOneMinusEpsilon})
          for (const Vec2f& u :
               {Vec2f(0, 0), Vec2f(kOneMinusEpsilon, 0), Vec2f(0, kOneMinusEpsilon),
                Vec2f(kOneMinusEpsilon, kOneMinusEpsilon), Vec2f(0.3f, 0.7f)}) {
            const LightQuery query{p, Vec3f(0, 1, 0), pick == 0.5f};
            const LightSample s = lights.sample(query, pick, u);
            if (s.kind == LightKind::kNone) continue;
            ASSERT_TRUE(s.pdf > 0 && std::isfinite(s.pdf));
            ASSERT_TRUE(is_finite(s.direction) && is_finite(s.position) && is_finite(s.radiance));
            ASSERT_NEAR(dot(s.direction, s.direction), 1, 1e-5f);
          }
  }
}

TEST(LightSampler, SaysWhatItIs) {
  Triangles quad;
  add_quad(quad, {0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1});
  EXPECT_EQ(make(quad).describe(), "power (2 emitters)");
  EXPECT_EQ(make({quad[0]}).describe(), "power (1 emitter)");
  EXPECT_EQ(make({}, points_of(directional({0, -1, 0}, 1))).describe(), "1 directional");
  EXPECT_EQ(make(quad, points_of(directional({0, -1, 0}, 1)),
                 std::make_shared<EnvironmentLight>(Rgb(1.0f)))
                .describe(),
            "power (2 emitters), 1 directional, environment");
  EXPECT_TRUE(make({}).empty());
  EXPECT_GT(make(quad).bytes(), 2 * sizeof(EmissiveTriangle));
  LightSampler moved = make(quad);
  moved = make({}, points_of(point_light({0, 1, 0}, 1)));
  EXPECT_EQ(moved.triangles().size(), 0u);
}

}  // namespace
}  // namespace emberline
