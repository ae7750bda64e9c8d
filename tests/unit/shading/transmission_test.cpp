// Compares the clear dielectric with closed forms.

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/frame.h"
#include "renderer/core/moments.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/lobes/transmission_lobe.h"
#include "support/chi_square.h"
#include "support/directions.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using test::direction;
using test::TestRandom;

BsdfParameters glass(float alpha, float ior = 1.5f, bool thin = false) {
  return {.base_color = Rgb(1),
          .metallic = 0,
          .roughness = std::sqrt(alpha),
          .ior = ior,
          .transmission = 1,
          .thin_walled = thin};
}

BsdfSample draw(const SurfaceBsdf& bsdf, TestRandom& random) {
  const float lobe = random.next();
  return bsdf.sample(lobe, random.vec2());
}

TEST(Fresnel, HasItsCosineWeightedMeans) {
  // The means outside are 2 int F mu dmu in closed form. Inside, the mean is 1 - (1 - Favg) /
  // eta^2.
  const double want[][2] = {{1.33, .06593}, {1.5, .09178}, {2, .16060}};
  for (const auto& [ior, mean] : want) {
    double outside = 0, inside = 0;
    const int n = 200000;
    for (int i = 0; i < n; ++i) {
      const double mu = (i + .5) / n;
      outside += 2 * mu * double(fresnel_dielectric(float(mu), float(ior))) / n;
      inside += 2 * mu * double(fresnel_dielectric(float(mu), float(1 / ior))) / n;
    }
    EXPECT_NEAR(outside, mean, 2e-5);
    EXPECT_NEAR(inside, 1 - (1 - mean) / (ior * ior), 5e-5);
  }
  EXPECT_EQ(fresnel_dielectric(.3f, 1 / 1.5f), 1);
  EXPECT_NEAR(fresnel_dielectric(1, 1.5f), .04, 1e-6);
  EXPECT_NEAR(fresnel_dielectric(0, 1.5f), 1, 1e-6);
}

TEST(Transmission, SmoothGlassObeysSnell) {
  for (const bool inside : {false, true})
    for (const float mu : {1.0f, .9f, .8f}) {
      BsdfParameters p = glass(0);
      p.inside = inside;
      const Vec3f wo = direction(mu, 1);
      const SurfaceBsdf bsdf(p, wo);
      EXPECT_FALSE(bsdf.has_non_delta() || bsdf.transmits_non_delta());
      const BsdfSample s = bsdf.sample(.9999f, Vec2f(.5f));
      ASSERT_TRUE(s.valid && s.delta && s.transmitted);
      const float eta = inside ? 1 / 1.5f : 1.5f;
      EXPECT_NEAR(s.wi.x, -wo.x / eta, 1e-6);
      EXPECT_NEAR(s.wi.y, -wo.y / eta, 1e-6);
      EXPECT_LT(s.wi.z, 0);
      EXPECT_NEAR(dot(s.wi, s.wi), 1, 1e-6);
      EXPECT_NEAR(s.eta_scale, eta * eta, 1e-6);
      EXPECT_NEAR(s.weight.x * s.eta_scale, 1, 1e-5);  // (1 - F) over its probability
    }
}

TEST(Transmission, ThinWallsDoNotBend) {
  const SurfaceBsdf bsdf(glass(0, 1.5f, true), direction(.4f, 2));
  const BsdfSample s = bsdf.sample(.9999f, Vec2f(.5f));
  ASSERT_TRUE(s.valid && s.transmitted && s.delta);
  EXPECT_NEAR((s.wi + direction(.4f, 2)).length(), 0, 1e-6);
  EXPECT_EQ(s.eta_scale, 1);
  // A solid of index 1 does the same, rough or not.
  const SurfaceBsdf none(glass(.5f, 1), direction(.4f, 2));
  const BsdfSample t = none.sample(0, Vec2f(.3f));
  ASSERT_TRUE(t.valid && t.transmitted && t.delta);
  EXPECT_NEAR((t.wi + direction(.4f, 2)).length(), 0, 1e-6);
  EXPECT_NEAR(t.weight.x, 1, 1e-6);
  // An index of 0 reflects everything.
  EXPECT_NEAR(SurfaceBsdf(glass(0, 0), direction(.4f, 2)).sample(.9999f, Vec2f(.5f)).weight.x, 1,
              1e-6);
}

// Follows paths through a slab between parallel faces: R = 2 F / (1 + F), T = 1 - R. If a crossing
// transmits a, then T = (1 - F)^2 a / (1 - F^2 a^2).
TEST(Transmission, SlabMeetsTheGeometricSeries) {
  const double want[][2] = {{0, .076923}, {.5, .079216}, {1, .143891}, {1.3, .390510}};
  for (const auto& [angle, reflectance] : want)
    for (const double sigma : {0.0, 0.7}) {
      const double cos_t = std::sqrt(1 - square(std::sin(angle) / 1.5));
      Moments reflected, transmitted;
      for (uint64_t i = 0; i < 100000; ++i) {
        TestRandom random(11, i);
        Vec3f d = direction(float(-std::cos(angle)), 0);  // direction of travel
        double weight = 1;
        bool inside = false;
        for (int bounce = 0; bounce < 200; ++bounce) {
          BsdfParameters p = glass(0);
          p.inside = inside;
          const float flip = d.z < 0 ? 1.0f : -1.0f;
          const SurfaceBsdf bsdf(p, Vec3f(-d.x, -d.y, -d.z * flip));
          const BsdfSample s = draw(bsdf, random);
          ASSERT_TRUE(s.valid);
          weight *= double(s.weight.x);
          d = Vec3f(s.wi.x, s.wi.y, s.wi.z * flip);
          if (s.transmitted) inside = !inside;
          if (!inside) break;
          weight *= double(beer_transmittance(Rgb(float(sigma)), float(1 / cos_t)).x);
        }
        reflected.add(d.z > 0 ? weight : 0);
        transmitted.add(d.z < 0 ? weight : 0);
      }
      const double f = double(fresnel_dielectric(float(std::cos(angle)), 1.5f));
      const double a = std::exp(-sigma / cos_t);
      const double t = square(1 - f) * a / (1 - square(f * a));
      EXPECT_NEAR(2 * f / (1 + f), reflectance, 2e-6);
      EXPECT_NEAR(reflected.mean(), f + f * a * t, 5 * reflected.standard_error() + 1e-4);
      EXPECT_NEAR(transmitted.mean(), t, 5 * transmitted.standard_error() + 1e-4);
    }
}

// A closed sphere of white glass in a furnace is invisible.
TEST(Transmission, GlassSphereVanishesInTheFurnace) {
  for (const float alpha : {0.0f, .01f, .1f, .4f})
    for (const float mu : {.95f, .4f}) {
      Moments radiance;
      for (uint64_t i = 0; i < 40000; ++i) {
        TestRandom random(12, i);
        // The sphere has radius 1. The ray travels along d and hits the sphere at n.
        Vec3f n(0, 0, 1), d = -direction(mu, 0);
        double weight = 1;
        bool inside = false, left = false;
        for (int bounce = 0; bounce < 300 && !left; ++bounce) {
          const Vec3f side = inside ? -n : n;
          const ShadingFrame frame = ShadingFrame::from_normal(side);
          BsdfParameters p = glass(alpha);
          p.inside = inside;
          const SurfaceBsdf bsdf(p, frame.to_local(-d));
          const BsdfSample s = draw(bsdf, random);
          if (!s.valid) {
            weight = 0;
            break;
          }
          weight *= double(s.weight.x);
          d = normalize(frame.to_world(s.wi));
          if (s.transmitted) inside = !inside;
          left = !inside;
          if (inside) n = normalize(n - d * (2 * dot(n, d)));  // end of the chord
        }
        radiance.add(weight);
      }
      EXPECT_NEAR(radiance.mean(), 1, 5 * radiance.standard_error() + 4e-3)
          << "alpha " << alpha << " mu " << mu;
    }
}

TEST(Transmission, FurnaceIsWhiteAtEveryRoughness) {
  for (const bool thin : {true, false})
    for (const bool inside : {false, true})
      for (const float alpha : {1e-3f, .01f, .1f, .4f})
        for (const float mu : {1.0f, .6f, .2f, .02f}) {
          BsdfParameters p = glass(alpha, 1.5f, thin);
          p.inside = inside;
          const SurfaceBsdf bsdf(p, direction(mu, 1));
          Moments got;
          for (uint64_t i = 0; i < 20000; ++i) {
            TestRandom random(13, i);
            const BsdfSample s = draw(bsdf, random);
            got.add(s.valid ? double(s.weight.x) * double(s.eta_scale) : 0);
          }
          EXPECT_NEAR(got.mean(), 1, 5 * got.standard_error() + 4e-3)
              << "thin " << thin << " inside " << inside << " alpha " << alpha << " mu " << mu;
        }
}

TEST(Transmission, SamplesFollowTheDensity) {
  struct Case {
    float alpha, mu, ior, transmission;
    bool thin, inside;
  };
  const Case cases[] = {{.2f, .8f, 1.5f, 1, false, false},   {.2f, .8f, 1.5f, 1, false, true},
                        {.5f, .3f, 1.2f, 1, false, true},    {.4f, .5f, 1.5f, 1, true, false},
                        {.3f, .6f, 1.5f, .5f, false, false}, {.1f, .9f, 2.4f, 1, false, false}};
  for (const Case& c : cases) {
    BsdfParameters p = glass(c.alpha, c.ior, c.thin);
    p.base_color = Rgb(.9f, .6f, .3f);
    p.transmission = c.transmission;
    p.inside = c.inside;
    p.metallic = c.transmission < 1 ? .3f : 0;
    const SurfaceBsdf bsdf(p, direction(c.mu, .7f));
    EXPECT_TRUE(bsdf.transmits_non_delta());
    EXPECT_TRUE(test::chi_square_directions(
        [&](TestRandom& random) -> std::optional<Vec3f> {
          const BsdfSample s = draw(bsdf, random);
          if (!s.valid) return std::nullopt;
          return s.wi;
        },
        [&](const Vec3f& wi) { return double(test::pdf_of(bsdf, wi)); },
        {.bins_x = 32, .samples = 200'000, .tests = int(std::size(cases))}))
        << "alpha " << c.alpha << " mu " << c.mu << " thin " << c.thin << " inside " << c.inside;
  }
}

// Apart from the 1 / eta^2 of radiance and the compensation at wo, refraction is reciprocal. For
// Walter's f, f(i, o) eta_o^2 = f(o, i) eta_i^2 (Veach 1997, section 5.2).
TEST(Transmission, RefractionIsReciprocalUpToEtaSquared) {
  for (uint64_t i = 0; i < 2000; ++i) {
    TestRandom random(14, i);
    const float roughness = .3f + .6f * random.next(), ior = 1.1f + random.next();
    const Vec3f wo = direction(.05f + .95f * random.next(), 6.28f * random.next());
    const Vec3f wi = -direction(.05f + .95f * random.next(), 6.28f * random.next());
    TransmissionParameters p{.roughness = roughness, .ior = ior, .thin_walled = false};
    float pdf;
    const double there = double(TransmissionLobe(p, wo).eval_and_pdf(wi, &pdf).x) *
                         double(refraction_albedo(wo.z, roughness, ior)) / double(-wi.z);
    p.inside = true;
    const Vec3f flipped_wo(wi.x, wi.y, -wi.z), flipped_wi(wo.x, wo.y, -wo.z);
    const double back = double(TransmissionLobe(p, flipped_wo).eval_and_pdf(flipped_wi, &pdf).x) *
                        double(refraction_albedo(-wi.z, roughness, 1 / ior)) / double(wo.z);
    ASSERT_NEAR(there * square(double(ior)), back, 1e-3 * (back + 1e-3)) << "TestRandom(14, " << i;
  }
}

TEST(Transmission, SweepStaysFiniteAndConsistent) {
  for (uint64_t i = 0; i < 200000; ++i) {
    TestRandom random(15, i);
    BsdfParameters p;
    p.base_color = Rgb(random.next(), random.next(), random.bits() & 1 ? 0.0f : 1.0f);
    p.metallic = std::max(0.0f, random.next() - .6f);
    p.roughness = random.next() < .3f ? .0317f : random.next();
    const float iors[] = {0, 1, 1.0005f, 1.002f, 1.5f, 4, 100};
    p.ior = random.next() < .5f ? iors[random.bits() % 7] : 1 + random.next();
    p.specular = random.next() < .2f ? random.next() : 1;
    p.transmission = random.next() < .5f ? 1 : random.next();
    p.thin_walled = random.bits() & 1;
    p.inside = random.bits() & 1;
    const auto cosine = [&] {
      const float x = random.next();
      return x < .1f ? 1e-6f : x < .2f ? 1.0f : random.next();
    };
    const Vec3f wo = direction(cosine(), 6.28f * random.next());
    Vec3f ng = direction(random.next(), 6.28f * random.next());
    if (dot(ng, wo) < 0 || random.next() < .5f) ng = Vec3f(0, 0, 1);
    const SurfaceBsdf bsdf(p, wo, ng);
    const BsdfSample s = draw(bsdf, random);
    Vec3f other = direction(cosine(), 6.28f * random.next());
    if (random.bits() & 1) other.z = -other.z;
    float pdf;
    const Rgb value = bsdf.eval_and_pdf(other, &pdf);
    ASSERT_TRUE(is_finite(value) && std::isfinite(pdf) && pdf >= 0) << "TestRandom(15, " << i;
    ASSERT_TRUE(value.x >= 0 && value.y >= 0 && value.z >= 0) << "TestRandom(15, " << i;
    ASSERT_TRUE(is_finite(bsdf.albedo())) << "TestRandom(15, " << i;
    if (!s.valid) continue;
    ASSERT_TRUE(is_finite(s.weight) && is_finite(s.wi)) << "TestRandom(15, " << i;
    ASSERT_NEAR(dot(s.wi, s.wi), 1, 2e-5f) << "TestRandom(15, " << i;
    ASSERT_EQ(s.transmitted, s.wi.z < 0) << "TestRandom(15, " << i;
    ASSERT_EQ(s.transmitted, dot(s.wi, ng) < 0) << "TestRandom(15, " << i;
    ASSERT_LT(max_component(s.weight) * s.eta_scale, 60) << "TestRandom(15, " << i;
    if (s.delta) continue;
    ASSERT_NEAR(test::pdf_of(bsdf, s.wi), s.pdf, 1e-4f * s.pdf) << "TestRandom(15, " << i;
  }
}

TEST(Transmission, NothingFromBehindOrNowhere) {
  for (const Vec3f& wo : {direction(-.5f, 0), Vec3f(1, 0, 0), Vec3f(NAN, NAN, NAN)})
    for (const float alpha : {0.0f, .3f}) {
      const TransmissionLobe lobe({.roughness = std::sqrt(alpha), .thin_walled = false}, wo);
      EXPECT_FALSE(lobe.sample(.5f, Vec2f(.3f)).valid);
      float pdf;
      EXPECT_EQ(lobe.eval_and_pdf(Vec3f(0, 0, -1), &pdf), Rgb(0));
      EXPECT_EQ(pdf, 0);
      EXPECT_TRUE(is_finite(lobe.albedo()));
    }
}

// The straight transmission equals the mean of the samples that pass straight through, over a fine
// grid of the number that selects the lobe. Only smooth thin walls have straight transmission.
TEST(Transmission, StraightThroughIsTheMeanOfItsSamples) {
  for (int i = 0; i < 60; ++i) {
    TestRandom random(16, uint64_t(i));
    BsdfParameters p = glass(0, i % 7 == 0 ? 0.0f : 1 + random.next(), true);
    p.base_color = Rgb(random.next(), random.next(), random.next());
    p.metallic = random.next() < .5f ? 0 : random.next();
    p.transmission = random.next() < .5f ? 1 : random.next();
    p.specular = random.next() < .5f ? 1 : random.next();
    const bool rough = i % 5 == 3, solid = i % 5 == 4;
    if (rough) p.roughness = .4f;
    p.thin_walled = !solid;
    const SurfaceBsdf bsdf(p, direction(.05f + .95f * random.next(), 6.28f * random.next()),
                           direction(.99f, 1));
    Rgb mean(0);
    constexpr int kSteps = 20000;
    for (int k = 0; k < kSteps; ++k) {
      const BsdfSample s = bsdf.sample((float(k) + .5f) / kSteps, Vec2f(.4f));
      if (s.valid && s.delta && s.transmitted && p.thin_walled) mean += s.weight / float(kSteps);
    }
    const Rgb straight = bsdf.straight_transmittance();
    // A step of the grid is worth 1 / 20000 of a weight, and a weight is at most 50 (kPickFloor).
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(straight[c], mean[c], 5e-3) << "TestRandom(16, " << i;
    EXPECT_TRUE((!rough && !solid && p.ior > 0) || straight == Rgb(0)) << i;
  }
}

TEST(Attenuation, IsBeersLaw) {
  const Rgb sigma = attenuation_coefficient(Rgb(.25f, 1, 0), 2);
  EXPECT_NEAR(beer_transmittance(sigma, 1).x, .5f, 1e-6);
  EXPECT_EQ(beer_transmittance(sigma, 7).y, 1);
  EXPECT_NEAR(beer_transmittance(sigma, 1).z, 1e-3f, 1e-6);
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  EXPECT_EQ(attenuation_coefficient(Rgb(.5f), inf), Rgb(0));
  EXPECT_EQ(attenuation_coefficient(Rgb(.5f), 0), Rgb(0));
  EXPECT_EQ(attenuation_coefficient(Rgb(.5f), nan), Rgb(0));
  EXPECT_TRUE(is_finite(attenuation_coefficient(Rgb(nan, -1, inf), 1)));
  const Rgb dense = attenuation_coefficient(Rgb(.5f), 1e-44f);
  EXPECT_EQ(beer_transmittance(dense, 0), Rgb(1));
  EXPECT_EQ(beer_transmittance(dense, 1), Rgb(0));
}

}  // namespace
}  // namespace emberline
