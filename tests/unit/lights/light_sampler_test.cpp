// Compares the choice among all lights with irradiance in closed form.
#include "renderer/lights/light_sampler.h"

#include <gtest/gtest.h>

#include "renderer/core/warps.h"
#include "support/light_scenes.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): the scenes of these tests

// ---- closed forms ------------------------------------------------------------------------------

TEST(LightSampler, Rectangle) {
  Triangles quad;  // faces down, towards the receiver (case 6)
  add_quad(quad, {-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f});
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  EXPECT_NEAR(exact_irradiance(quad, query), 0.683537, 1e-6);
  for (uint32_t threshold : {1u, 16u})
    expect_irradiance(make_light_sampler(quad, {}, nullptr, threshold), query, 0.683537,
                      "threshold", 50'000, 1e-5);
  // A rectangle gives nothing from behind, unless it is two-sided.
  const LightQuery behind{Vec3f(0, 2.4f, 0), Vec3f(0, -1, 0)};
  EXPECT_EQ(estimate(make_light_sampler(quad), behind, 1000, 1).mean(), 0);
  for (EmissiveTriangle& t : quad) t.two_sided = true;
  expect_irradiance(make_light_sampler(quad), behind, 0.683537, "two-sided, behind");
}

TEST(LightSampler, HorizonCutsARectangle) {
  Triangles quad;
  add_quad(quad, {1, -1, -1}, {1, -1, 1}, {1, 1.5f, 1}, {1, 1.5f, -1});
  for (const Vec3f& n :
       {Vec3f(0, 1, 0), normalize(Vec3f(1, 1, 0.3f)), normalize(Vec3f(-1, 2, 0))}) {
    LightQuery query{Vec3f(0.0f), n};
    expect_irradiance(make_light_sampler(quad), query, exact_irradiance(quad, query), "cut");
    query.both_sides = true;
    expect_irradiance(make_light_sampler(quad), query, exact_irradiance(quad, query), "both sides");
  }
}

TEST(LightSampler, TessellatedSphere) {
  // Case 7: the smooth sphere would give pi (R/d)^2 cos, but the polygons have their own exact sum.
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
    expect_irradiance(make_light_sampler(ball), query, exact, "sphere, light BVH");
    expect_irradiance(make_light_sampler(ball, {}, nullptr, 1u << 20), query, exact,
                      "sphere, power", 200'000);
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
    expect_irradiance(make_light_sampler(disc), query, exact, "disc");
  }
}

TEST(LightSampler, PointAndSpot) {
  const Vec3f position(1, 2, -2);  // distance 3
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  expect_irradiance(make_light_sampler({}, points_of(point_light(position, 5))), query,
                    5 * (2.0 / 3) / 9, "point", 100);

  PointLight spot = point_light(position, 5);
  spot.type = PointLightType::kSpot;
  const double cosine = 0.8;  // between the axis and the direction to the query
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
      expect_irradiance(make_light_sampler({}, points_of(spot), nullptr, threshold), query,
                        5 * (2.0 / 3) / 9 * c.attenuation, "spot", 100, 1e-4);
  }
}

// By KHR_lights_punctual, a light gives nothing beyond its range. No sample goes to a light that is
// out of range.
TEST(LightSampler, LightsHaveARange) {
  std::vector<PointLight> points;
  for (int i = 0; i < 40; ++i) {
    TestRandom random(40, uint64_t(i));
    PointLight light = point_light({random.next() * 20 - 10, 1 + random.next(), random.next()}, 5);
    light.range = i % 4 == 0 ? kInfinity : 1 + 4 * random.next();
    if (i % 3 == 0) {
      light.type = PointLightType::kSpot;
      light.direction = Vec3f(0, -1, 0);
      light.cos_inner = 0.1f;
    }
    points.push_back(light);
  }
  const auto sky = std::make_shared<EnvironmentLight>(Rgb(0.5f));
  for (const float x : {-9.0f, 0.0f, 4.0f, 500.0f}) {
    const LightQuery query{Vec3f(x, 0, 0), Vec3f(0, 1, 0)};
    double exact = 0;
    for (const PointLight& light : points) {
      const Vec3d to_light = Vec3d(light.position) - Vec3d(query.point);
      const double d2 = dot(to_light, to_light), cosine = to_light.y / std::sqrt(d2);
      if (d2 > square(double(light.range))) continue;
      const double cone =
          light.type == PointLightType::kSpot ? std::clamp(cosine / 0.1, 0.0, 1.0) : 1;
      exact += 5 * cone * cone * cosine / d2;
    }
    for (const uint32_t threshold : {1u, 1000u}) {
      const LightSampler lights = make_light_sampler({}, points, nullptr, threshold);
      expect_irradiance(lights, query, exact, "ranges", 100'000, 1e-4);
      if (threshold == 1000) {
        for (int i = 0; i < 1000; ++i) {
          TestRandom random(41, uint64_t(i));
          const float pick = random.next();
          const LightSample s = test::sample_one(lights, query, pick, random.vec2());
          ASSERT_TRUE(s.kind == LightKind::kPoint);
          ASSERT_LE(s.distance, points[s.index].range);
        }
      }
      expect_irradiance(make_light_sampler({}, points, sky, threshold), query, exact + 0.5 * kPiD,
                        "ranges and sky", 200'000, 1e-4);
    }
  }
}

TEST(LightSampler, LampsOutOfRangeTakeNoSamples) {
  for (const int count : {1, 40}) {
    std::vector<PointLight> points;
    for (int i = 0; i < count; ++i) {
      points.push_back(point_light({0, 3 + 0.01f * float(i), 0}, 1000));
      points.back().range = 2.5f;
    }
    const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
    EXPECT_EQ(estimate(make_light_sampler({}, points), query, 100, 1).mean(), 0);
    const LightSampler both =
        make_light_sampler({}, points, std::make_shared<EnvironmentLight>(Rgb(0.5f)));
    EXPECT_EQ(both.environment_probability(query), 1.0f);
    EXPECT_EQ(both.kind_probabilities(query)[kFiniteKind], 0.0f);
    EXPECT_LT(both.environment_probability({Vec3f(0, 1, 0), Vec3f(0, 1, 0)}), 1.0f);
  }
}

TEST(LightSampler, ARangeMayChange) {
  PointLight light = point_light({0, 2, 0}, 4);
  light.range = 8;
  light.range_scale =
      std::make_shared<const TimeCurve<float>>(TimeCurve<float>{{0, 1}, {0.0f, 1.0f}});
  for (const uint32_t threshold : {1u, 16u}) {
    const LightSampler lights = make_light_sampler({}, points_of(light), nullptr, threshold);
    for (const float time : {0.0f, 0.24f, 0.26f, 1.0f}) {
      const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0), false, time};
      EXPECT_NEAR(estimate(lights, query, 100, 1).mean(), time > 0.25f ? 1 : 0, 1e-6) << time;
    }
  }
}

TEST(LightSampler, PointPowerThroughAClosedBox) {
  // Case 10: the flux of a point light of intensity 2 through any closed surface around it is 8 pi.
  Moments flux;
  for (uint64_t draw = 0; draw < 200'000; ++draw) {
    TestRandom random(5, draw);
    const int side = int(random.bits() % 6);
    Vec3f at(random.next() * 2 - 1, random.next() * 2 - 1, random.next() * 2 - 1), n(0.0f);
    at[side / 2] = side & 1 ? 1.0f : -1.0f;
    n[side / 2] = -at[side / 2];
    static const LightSampler lights =
        make_light_sampler({}, points_of(point_light({0.3f, -0.2f, 0.1f}, 2)));
    const LightQuery query{at, n};
    flux.add(24 * irradiance_of(lights, query,
                                test::sample_one(lights, query, random.next(), random.vec2())));
  }
  EXPECT_NEAR(flux.mean(), 8 * kPiD, 4.9 * flux.standard_error());
}

// Inside a closed box of emitters the irradiance is pi everywhere.
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
        expect_irradiance(make_light_sampler(box, {}, nullptr, threshold), query, kPiD, "box",
                          100'000);
      }
  }
}

TEST(LightSampler, InfiniteAndFiniteTogether) {
  Triangles quad;
  add_quad(quad, {-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f}, 3.0f);
  const auto sky = std::make_shared<EnvironmentLight>(Rgb(0.5f));
  const std::vector<PointLight> points =
      points_of(point_light({0, 2, 0}, 4), directional({0, -1, 0}, 2), directional({0, -1, 3}, 5),
                directional({0, 1, 0.2f}, 50));  // the last shines from below
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  const double exact = 3 * 0.683537 + 0.5 * kPiD + 1 + 2 + 5 / std::sqrt(10.0);
  for (uint32_t threshold : {1u, 16u})
    expect_irradiance(make_light_sampler(quad, points, sky, threshold), query, exact, "all",
                      200'000);
  LightQuery both = query;
  both.both_sides = true;
  expect_irradiance(make_light_sampler(quad, points, sky), both,
                    exact + 0.5 * kPiD + 50 / std::sqrt(1.04), "both", 200'000);
}

// ---- many lamps --------------------------------------------------------------------------------

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
  const LightSampler tree = make_light_sampler(all),
                     power = make_light_sampler(all, {}, nullptr, 1u << 30);
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
    // Only one of the lamps is visible, the fifth nearest.
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
      const LightSample s = test::sample_one(tree, query, pick, random.vec2());
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
    const LightSampler lights = make_light_sampler(two, {}, nullptr, threshold);
    const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
    expect_irradiance(lights, query, exact_irradiance(two, query), "near and far");
    // Estimates the far lamp alone, from the samples of both.
    Moments far;
    for (int i = 0; i < 200'000; ++i) {
      // The stratification is as fine as the tree's smallest probability requires.
      const float pick = (float(i) + 0.5f) / 200'000;
      const LightSample s =
          test::sample_one(lights, query, pick, TestRandom(31, uint64_t(i)).vec2());
      if (s.kind == LightKind::kTriangle && s.index >= 2) far.add(irradiance_of(lights, query, s));
    }
    for (uint32_t index : {2u, 3u}) {
      const Vec3f to = two[index].p0 - query.point;
      EXPECT_GT(lights.pdf_triangle(query, index, to.length()), 0);
    }
    if (threshold == 16) {
      EXPECT_NEAR(double(far.count()) / 200'000, 0.5, 1e-3);
    }
  }
}

}  // namespace
}  // namespace emberline
