// Tests the pdfs of the light sampler, of samples, of hits and over the sphere, and lights without
// a pdf.
#include <gtest/gtest.h>

#include <map>

#include "renderer/core/ray.h"
#include "renderer/core/warps.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_guide.h"
#include "renderer/lights/light_sampler.h"
#include "support/light_scenes.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): the scenes of these tests

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
      const LightSampler lights = make_light_sampler(scene.triangles, scene.points, scene.sky);
      int seen = 0;
      for (uint64_t draw = 0; draw < 12000; ++draw) {
        TestRandom random(41, draw);
        const LightQuery query{square_to_sphere(random.vec2()) * (3 * random.next() * scale),
                               square_to_sphere(random.vec2()), random.next() < 0.3f};
        const float pick = random.next();
        const LightSample s = test::sample_one(lights, query, pick, random.vec2());
        if (s.kind == LightKind::kNone) continue;
        ASSERT_GT(s.pdf, 0);
        ASSERT_TRUE(std::isfinite(s.pdf) && is_finite(s.radiance) && is_finite(s.direction));
        if (s.kind == LightKind::kEnvironment) {
          ASSERT_EQ(s.pdf, test::pdf_environment(lights, query, s.direction));
        }
        if (s.kind != LightKind::kTriangle) continue;
        ++seen;
        ASSERT_EQ(s.pdf, lights.pdf_triangle(query, s.index, s.distance));
        // The position, barycentrics, direction and distance describe the same point.
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

// The kinds of light are chosen with the stated probabilities, which the factors of the guide
// change.
TEST(LightSampler, KindsArePickedWithTheirProbability) {
  const MixedScene scene = mixed_scene(30, 1.0f);
  const LightSampler lights = make_light_sampler(scene.triangles, scene.points, scene.sky);
  for (const KindFactors& factors : {KindFactors{}, KindFactors{0.25f, 1, 0.05f},
                                     KindFactors{8, 0.125f, 0.1f}, KindFactors{1, 64, 0.01f}}) {
    const LightGuide guide{.factors = factors};
    std::array<Moments, kLightKinds> picked;
    std::array<double, kLightKinds> told{};
    constexpr int kDraws = 100'000;
    for (uint64_t draw = 0; draw < kDraws; ++draw) {
      TestRandom random(42, draw);
      const LightQuery query{square_to_sphere(random.vec2()) * (3 * random.next()),
                             square_to_sphere(random.vec2()), random.next() < 0.3f};
      const float pick = random.next();
      const LightRequest request{query, pick, random.vec2()};
      LightSample s;
      LightSample* const out = &s;
      lights.sample({&request, 1}, &out, &guide);
      const bool sun = s.kind == LightKind::kPoint && s.distance == kInfinity;
      const std::array<float, kLightKinds> probabilities = lights.kind_probabilities(query, &guide);
      ASSERT_NEAR(probabilities[0] + probabilities[1] + probabilities[2], 1, 1e-5f);
      picked[kEnvironmentKind].add(s.kind == LightKind::kEnvironment ? 1.0 : 0.0);
      picked[kDirectionalKind].add(sun ? 1.0 : 0.0);
      for (size_t k = 0; k < kLightKinds; ++k) told[k] += double(probabilities[k]) / kDraws;
      if (s.kind == LightKind::kEnvironment) {
        ASSERT_EQ(s.pdf, lights.environment_probability(query, &guide) *
                             test::pdf_of(*lights.environment(), s.direction));
      } else if (s.kind == LightKind::kTriangle) {
        ASSERT_EQ(s.pdf, lights.pdf_triangle(query, s.index, s.distance, &guide));
      } else if (sun) {
        ASSERT_NEAR(s.pdf, probabilities[kDirectionalKind], 1e-6f);
      }
    }
    for (const size_t k : {kEnvironmentKind, kDirectionalKind}) {
      EXPECT_NEAR(picked[k].mean(), told[k], 5.5 * picked[k].standard_error())
          << k << " factors " << factors.environment << ", " << factors.directional;
    }
    EXPECT_GE(told[kFiniteKind], double(factors.min_share) - 1e-6);
  }
}

// A sun that no survey path has reached keeps a minimum share of the samples where it can shine.
TEST(LightSampler, SunsKeepTheirLeastShare) {
  const auto sky = std::make_shared<EnvironmentLight>(Rgb(1.0f));
  const std::vector<PointLight> suns =
      points_of(directional({0, -1, 0}, 1e-3f), directional({0, -1, -1}, 3e-3f));
  const LightSampler lights = make_light_sampler({}, suns, sky);
  const LightGuide guide{.factors = {256, 1, 0.05f, 0.05f}};
  const LightQuery up{Vec3f(0.0f), Vec3f(0, 1, 0)}, down{Vec3f(0.0f), Vec3f(0, -1, 0)};
  EXPECT_NEAR(lights.kind_probabilities(up, &guide)[kDirectionalKind], 0.05f / 1.05f, 1e-6f);
  EXPECT_EQ(lights.kind_probabilities(down, &guide)[kDirectionalKind], 0.0f);
  EXPECT_LT(lights.kind_probabilities(up)[kDirectionalKind], 0.01f);
  // The irradiance is that of both suns and the sky, each with the stated pdf.
  Moments irradiance;
  for (uint64_t draw = 0; draw < 100'000; ++draw) {
    TestRandom random(43, draw);
    const float pick = random.next();
    const LightRequest request{up, pick, random.vec2()};
    LightSample s;
    LightSample* const out = &s;
    lights.sample({&request, 1}, &out, &guide);
    irradiance.add(s.pdf > 0.0f ? double(luminance(s.radiance) * std::max(0.0f, s.direction.y)) /
                                      double(s.pdf)
                                : 0.0);
  }
  const double exact = kPiD + 1e-3 + 3e-3 / std::sqrt(2.0);
  EXPECT_NEAR(irradiance.mean(), exact, 5.5 * irradiance.standard_error());
}

// Lights whose sum overflows float are still weighted relative to each other.
TEST(LightSampler, TheBrightestLightsHaveDensities) {
  const auto sky = std::make_shared<EnvironmentLight>(Rgb(1.6e38f));
  const std::vector<PointLight> suns =
      points_of(directional({0, -1, 0}, 3e38f), directional({0, -1, 1}, 3e38f));
  const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0)};
  for (const auto& points : {std::vector<PointLight>(), suns}) {
    const LightSampler lights = make_light_sampler({}, points, sky);
    for (const LightGuide& guide :
         {LightGuide(), LightGuide{.factors = {256, 256, 0.05f, 0.05f}}}) {
      const float probability = lights.environment_probability(query, &guide);
      EXPECT_GT(probability, 0.3f);
      EXPECT_LE(probability, 1.0f);
      for (const float pick : {0.0f, 0.4f, 0.99f}) {
        const LightRequest request{query, pick, Vec2f(0.3f, 0.6f)};
        LightSample s;
        LightSample* const out = &s;
        lights.sample({&request, 1}, &out, &guide);
        EXPECT_TRUE(s.pdf > 0.0f && std::isfinite(s.pdf)) << pick;
      }
    }
  }
}

// Over uniform directions, the pdfs of all triangles that a ray hits add up to the probability of
// sampling a triangle. The points and the environment have the rest.
TEST(LightSampler, DensitiesAddUpToOne) {
  const MixedScene scene = mixed_scene(30, 1.0f);
  for (uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights =
        make_light_sampler(scene.triangles, scene.points, scene.sky, threshold);
    for (uint64_t q = 0; q < 4; ++q) {
      TestRandom first(50, q);
      const LightQuery query{square_to_sphere(first.vec2()) * (2 * first.next()),
                             square_to_sphere(first.vec2()), q == 3};
      Moments integral, sampled;
      for (uint64_t draw = 0; draw < 100'000; ++draw) {
        TestRandom random(51, draw);
        const Vec3f w = square_to_sphere(random.vec2());
        double sum = double(test::pdf_environment(lights, query, w));
        for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
          const EmissiveTriangle& t = scene.triangles[i];
          const Vec3d e1 = Vec3d(t.p1) - Vec3d(t.p0), e2 = Vec3d(t.p2) - Vec3d(t.p0);
          const Vec3d d(w), s = Vec3d(query.point) - Vec3d(t.p0), p = cross(d, e2);
          const double det = dot(e1, p), b1 = dot(s, p) / det, b2 = dot(d, cross(s, e1)) / det;
          const double distance = dot(e2, cross(s, e1)) / det;
          if (b1 >= 0 && b2 >= 0 && b1 + b2 <= 1 && distance > 0)
            sum += double(lights.pdf_triangle(query, i, float(distance)));
        }
        integral.add(sum * 4 * kPiD);
        const float pick = random.next();
        const LightSample s = test::sample_one(lights, query, pick, random.vec2());
        sampled.add(s.kind == LightKind::kTriangle || s.kind == LightKind::kEnvironment ? 1.0
                                                                                        : 0.0);
      }
      const double error = std::hypot(integral.standard_error(), sampled.standard_error());
      EXPECT_NEAR(integral.mean(), sampled.mean(), 5.5 * error) << q << " threshold " << threshold;
      EXPECT_GT(integral.mean(), 0.3);
    }
  }
}

// Compares the frequencies of the choices with the probabilities that the samples state, by
// chi-square.
TEST(LightSampler, PicksAreAsFrequentAsStated) {
  const MixedScene scene = mixed_scene(40, 1.0f);
  for (uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights =
        make_light_sampler(scene.triangles, scene.points, scene.sky, threshold);
    const LightQuery query{Vec3f(0.1f, -0.3f, 0.5f), Vec3f(0, 1, 0), true};
    const int kSamples = 400'000;
    std::map<std::pair<int, uint32_t>, std::pair<double, int>> bins;  // probability, count
    for (int i = 0; i < kSamples; ++i) {
      TestRandom random(60, uint64_t(i));
      const float pick = random.next();
      const LightSample s = test::sample_one(lights, query, pick, random.vec2());
      if (s.kind == LightKind::kNone) continue;
      auto& [probability, count] = bins[{int(s.kind), s.index}];
      probability = double(s.pdf);
      // Divides out the pdf within the shape. For a triangle, this is the pdf if it is the only
      // light.
      if (s.kind == LightKind::kTriangle)
        probability /= double(
            make_light_sampler({lights.triangles()[s.index]}).pdf_triangle(query, 0, s.distance));
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

// ---- lights that must not be sampled -----------------------------------------------------------

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
  const LightSampler broken =
      make_light_sampler(list, points, std::make_shared<EnvironmentLight>(Rgb(0.0f)));
  EXPECT_TRUE(broken.empty());
  EXPECT_EQ(broken.describe(), "none");
  EXPECT_EQ(broken.environment(), nullptr);
  EXPECT_EQ(test::sample_one(broken, query, 0.5f, {0.5f, 0.5f}).kind, LightKind::kNone);
  EXPECT_EQ(test::pdf_environment(broken, query, {0, 1, 0}), 0);

  const uint32_t good = uint32_t(list.size());
  add_quad(list, {-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f});
  for (uint32_t threshold : {1u, 16u}) {
    const LightSampler lights = make_light_sampler(list, points, nullptr, threshold);
    EXPECT_FALSE(lights.empty());
    for (uint32_t i = 0; i < good; ++i) EXPECT_EQ(lights.pdf_triangle(query, i, 1.0f), 0);
    for (uint64_t draw = 0; draw < 2000; ++draw) {
      TestRandom random(70, draw);
      const LightSample s = test::sample_one(lights, query, random.next(), random.vec2());
      ASSERT_EQ(s.kind, LightKind::kTriangle);
      ASSERT_GE(s.index, good);
    }
    expect_irradiance(lights, query, 0.683537, "with broken company");
  }
}

// The random numbers are at the ends of their range, and the query points are in degenerate
// positions.
TEST(LightSampler, NothingIsEverNotANumber) {
  const MixedScene scene = mixed_scene(60, 1.0f);
  for (uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights =
        make_light_sampler(scene.triangles, scene.points, scene.sky, threshold);
    for (const EmissiveTriangle& t : scene.triangles)
      for (const Vec3f& p : {t.p0, (t.p0 + t.p1) * 0.5f, (t.p0 + t.p1 + t.p2) * (1 / 3.0f),
                             t.p0 * 2.0f - t.p1, t.p0 * 1e6f, scene.points[0].position})
        for (float pick : {0.0f, 0.5f, kOneMinusEpsilon})
          for (const Vec2f& u :
               {Vec2f(0, 0), Vec2f(kOneMinusEpsilon, 0), Vec2f(0, kOneMinusEpsilon),
                Vec2f(kOneMinusEpsilon, kOneMinusEpsilon), Vec2f(0.3f, 0.7f)}) {
            const LightQuery query{p, Vec3f(0, 1, 0), pick == 0.5f};
            const LightSample s = test::sample_one(lights, query, pick, u);
            if (s.kind == LightKind::kNone) continue;
            ASSERT_TRUE(s.pdf > 0 && std::isfinite(s.pdf));
            ASSERT_TRUE(is_finite(s.direction) && is_finite(s.position) && is_finite(s.radiance));
            ASSERT_NEAR(dot(s.direction, s.direction), 1, 1e-5f);
          }
  }
}

TEST(LightSampler, DescribesItself) {
  Triangles quad;
  add_quad(quad, {0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1});
  EXPECT_EQ(make_light_sampler(quad).describe(), "power (2 emitters)");
  EXPECT_EQ(make_light_sampler({quad[0]}).describe(), "power (1 emitter)");
  EXPECT_EQ(make_light_sampler({}, points_of(directional({0, -1, 0}, 1))).describe(),
            "1 directional");
  EXPECT_EQ(make_light_sampler(quad, points_of(directional({0, -1, 0}, 1)),
                               std::make_shared<EnvironmentLight>(Rgb(1.0f)))
                .describe(),
            "power (2 emitters), 1 directional, environment");
  EXPECT_TRUE(make_light_sampler({}).empty());
  EXPECT_GT(make_light_sampler(quad).bytes(), 2 * sizeof(EmissiveTriangle));
  LightSampler moved = make_light_sampler(quad);
  moved = make_light_sampler({}, points_of(point_light({0, 1, 0}, 1)));
  EXPECT_EQ(moved.triangles().size(), 0u);
}

}  // namespace
}  // namespace emberline
