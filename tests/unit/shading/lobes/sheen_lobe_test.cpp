// Compares the sheen lobe with the published formula and its table with quadrature, and tests its
// sampling.
#include "renderer/shading/lobes/sheen_lobe.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/moments.h"
#include "support/chi_square.h"
#include "support/directions.h"

namespace emberline {
namespace {

using test::direction;
using test::TestRandom;

// The f of Estevez & Kulla 2017 as printed in KHR_materials_sheen, without limits.
double published(double roughness, const Vec3d& wo, const Vec3d& wi) {
  const double alpha = roughness * roughness, t = (1 - alpha) * (1 - alpha);
  const auto mix = [t](double x, double y) { return x * (1 - t) + y * t; };
  const double a = mix(21.5473, 25.3245), b = mix(3.82987, 3.32435), c = mix(0.19823, 0.16801);
  const double d = mix(-1.97760, -1.27393), e = mix(-4.32054, -4.85967);
  const auto l = [&](double x) { return a / (1 + b * std::pow(x, c)) + d * x + e; };
  const auto lambda = [&](double x) {
    return x < 0.5 ? std::exp(l(x)) : std::exp(2 * l(0.5) - l(1 - x));
  };
  Vec3d h = wo + wi;
  h /= std::sqrt(dot(h, h));
  const double sin2 = h.x * h.x + h.y * h.y;
  const double distribution = (2 + 1 / alpha) * std::pow(sin2, 0.5 / alpha) / (2 * kPiD);
  return distribution / ((1 + lambda(wo.z) + lambda(wi.z)) * 4 * wo.z * wi.z);
}

// The integral of value(wi) over the hemisphere, by the midpoint rule in t = cosine^(1/4) and the
// azimuth.
template <typename Value>
double integral(const Value& value, int n = 160) {
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double t = (i + .5) / n, mu = square(square(t)), r = std::sqrt(1 - mu * mu);
    for (int j = 0; j < n; ++j) {
      const double phi = 2 * kPiD * (j + .5) / n;
      sum += value(Vec3d(r * std::cos(phi), r * std::sin(phi), mu)) * 4 * t * t * t;
    }
  }
  return sum * 2 * kPiD / (double(n) * n);
}

double published_albedo(double roughness, double mu) {
  const Vec3d wo(std::sqrt(1 - mu * mu), 0, mu);
  return integral([&](const Vec3d& wi) {
    return wi.z < double(kSheenMinCosine) ? 0 : published(roughness, wo, wi) * wi.z;
  });
}

// max(1, R), smoothed as the header defines.
double limited(double r, double roughness) {
  const double t = std::clamp((roughness - .15) / .135, 0.0, 1.0), round = .15 + (.045 - .15) * t;
  if (r < 1 - round) return 1;
  return r < 1 + round ? 1 + square(r - 1 + round) / (4 * round) : r;
}

const float kRoughnesses[] = {kSheenMinRoughness, .1f, .2f, .3f, .5f, .7f, 1.0f};

TEST(SheenLobe, IsThePublishedOneWhereThatLosesEnergy) {
  for (uint64_t i = 0; i < 20000; ++i) {
    TestRandom random(41, i);
    const float roughness = .3f + .7f * random.next();
    const Vec3f wo = direction(1e-3f + .999f * random.next(), 6.28f * random.next());
    const Vec3f wi = direction(1e-3f + .999f * random.next(), 6.28f * random.next());
    const double want = published(double(roughness), to_double(wo), to_double(wi)) * double(wi.z);
    ASSERT_NEAR(double(SheenLobe(roughness, wo).eval(wi)), want, 1e-4 * want + 1e-7) << i;
  }
}

TEST(SheenLobe, IsDividedByThePublishedAlbedoWhereThatExceedsOne) {
  for (const double roughness : {.07, .09, .13, .2})
    for (const double mu_o : {.4, .06, .003})
      for (const double mu_i : {.15, .02, .0004}) {
        const Vec3d wo(std::sqrt(1 - mu_o * mu_o), 0, mu_o);
        const Vec3d wi(std::sqrt(1 - mu_i * mu_i) * .6, std::sqrt(1 - mu_i * mu_i) * .8, mu_i);
        const double largest =
            std::max(published_albedo(roughness, mu_o), published_albedo(roughness, mu_i));
        const double limit = limited(largest, roughness);
        const double want = published(roughness, wo, wi) * mu_i / limit;
        EXPECT_NEAR(double(SheenLobe(float(roughness), to_float(wo)).eval(to_float(wi))), want,
                    3e-3 * want + 1e-7)
            << roughness << " " << mu_o << " " << mu_i;
      }
}

TEST(SheenLobe, IsReciprocal) {
  for (uint64_t i = 0; i < 20000; ++i) {
    TestRandom random(42, i);
    const float roughness = random.next();
    const auto cosine = [&] {
      return random.next() < .3f ? std::pow(10.0f, -7 * random.next()) : random.next();
    };
    const Vec3f a = direction(cosine(), 6.28f * random.next());
    const Vec3f b = direction(cosine(), 6.28f * random.next());
    const float ab = SheenLobe(roughness, a).eval(b) / b.z;
    const float ba = SheenLobe(roughness, b).eval(a) / a.z;
    ASSERT_NEAR(ab, ba, 2e-4f * ab + 1e-7f) << "draw " << i;
  }
}

TEST(SheenLobe, AlbedoMeetsQuadrature) {
  double largest = 0;
  for (uint64_t i = 0; i < 300; ++i) {
    TestRandom random(43, i);
    const float roughness = i % 3 ? random.next() : .07f + .3f * random.next();
    const float mu = i % 2 ? random.next() : std::pow(10.0f, -4 * random.next());
    const SheenLobe lobe(roughness, direction(mu, 1));
    const double want = integral([&](const Vec3d& wi) { return double(lobe.eval(to_float(wi))); });
    const double error = std::abs(double(lobe.albedo(mu)) - want);
    EXPECT_LT(error, 1e-3) << "roughness " << roughness << " mu " << mu << " is " << want;
    largest = std::max(largest, error);
  }
  std::printf("largest error of an albedo: %.2e\n", largest);
}

TEST(SheenLobe, ReflectsAtMostTheIncomingLight) {
  for (float roughness = 0; roughness <= 1; roughness += .02f)
    for (float x = 0; x <= 8; x += .1f) {
      const float mu = std::pow(10.0f, -x);
      const float albedo = SheenLobe(roughness, direction(mu, 1)).albedo(mu);
      ASSERT_TRUE(albedo >= 0 && albedo <= 1);
    }
  // Tests the integral of the lobe itself, also below the last column of the table.
  for (const float roughness : kRoughnesses)
    for (const float mu : {1e-2f, 1e-3f, 1e-4f, 1e-5f, 1e-7f}) {
      const SheenLobe lobe(roughness, direction(mu, 1));
      const double sum =
          integral([&](const Vec3d& wi) { return double(lobe.eval(to_float(wi))); }, 100);
      EXPECT_LT(sum, 1.001) << "roughness " << roughness << " mu " << mu;
      EXPECT_NEAR(sum, double(lobe.albedo(mu)), 2e-3) << roughness << " mu " << mu;
    }
}

TEST(SheenLobe, SamplesFollowTheDensity) {
  const std::pair<float, float> cases[] = {{1, 1.0f},   {1, .3f},   {.5f, .5f}, {.3f, .1f},
                                           {.15f, .9f}, {.1f, .2f}, {0, .02f},  {.3f, 1e-5f}};
  for (const auto& [roughness, mu] : cases) {
    const SheenLobe lobe(roughness, direction(mu, 2));
    EXPECT_TRUE(test::chi_square_directions(
        [&](TestRandom& random) { return std::optional(lobe.sample(random.vec2())); },
        [&](const Vec3f& wi) { return double(lobe.pdf(wi)); },
        {.samples = 200'000, .seed = 44, .tests = int(std::size(cases))}, 0))
        << "roughness " << roughness << " mu " << mu;
  }
}

// The mean of the sample weights is the albedo. Their second moment and their maximum are bounded.
TEST(SheenLobe, WeightsAreBounded) {
  for (const float roughness : kRoughnesses)
    for (const float mu : {1.0f, .6f, .3f, .1f, .03f, .003f, 1e-5f}) {
      const SheenLobe lobe(roughness, direction(mu, 2));
      const float albedo = lobe.albedo(mu);
      double sum = 0, squares = 0, largest = 0;
      const int n = 1 << 16;
      for (int i = 0; i < n; ++i) {
        TestRandom random(45, uint64_t(i));
        const Vec3f wi = lobe.sample(Vec2f((float(i) + .5f) / n, random.next()));
        ASSERT_GT(wi.z, 0);
        const double weight = double(lobe.eval(wi)) / double(lobe.pdf(wi));
        ASSERT_TRUE(std::isfinite(weight) && weight >= 0);
        sum += weight / n;
        squares += weight * weight / n;
        largest = std::max(largest, weight);
      }
      // The tolerance includes six standard deviations.
      EXPECT_NEAR(sum, double(albedo), 6 * std::sqrt(squares / n) + 1e-3) << roughness << " " << mu;
      EXPECT_LT(largest, 3.2) << roughness << " " << mu;
      if (albedo < 1e-4f) continue;
      EXPECT_LT(squares / square(sum), 2.5) << roughness << " " << mu;
      EXPECT_LT(largest / sum, 4.5) << roughness << " " << mu;
    }
}

TEST(SheenLobe, SweepStaysFinite) {
  const float cosines[] = {1e-38f, 1e-20f, 1e-6f, 1e-4f, .05f, 1};
  for (uint64_t i = 0; i < 200000; ++i) {
    TestRandom random(46, i);
    const auto cosine = [&] {
      return random.next() < .3f ? cosines[random.bits() % 6] : random.next();
    };
    const float roughness = random.next() < .2f ? float(random.bits() & 1) : random.next();
    const Vec3f wo = direction(cosine(), 6.28f * random.next());
    const SheenLobe lobe(roughness, wo);
    const Vec3f s = lobe.sample(random.vec2());
    ASSERT_NEAR(dot(s, s), 1, 1e-5f) << i;
    const Vec3f mirror(-wo.x, -wo.y, wo.z), other = direction(cosine(), 6.28f * random.next());
    for (const Vec3f& wi : {s, mirror, wo, other}) {
      ASSERT_TRUE(std::isfinite(lobe.eval(wi)) && lobe.eval(wi) >= 0) << i;
      ASSERT_TRUE(std::isfinite(lobe.pdf(wi)) && lobe.pdf(wi) > 0) << i;
    }
  }
  for (const Vec3f& wo : {Vec3f(0, 0, -1), Vec3f(1, 0, 0), Vec3f(NAN, NAN, NAN)}) {
    const SheenLobe lobe(.5f, wo);
    EXPECT_EQ(lobe.eval(Vec3f(0, 0, 1)), 0);
    EXPECT_EQ(lobe.pdf(Vec3f(0, 0, 1)), 0);
  }
  const SheenLobe lobe(.5f, Vec3f(0, 0, 1));
  for (const Vec3f& wi : {Vec3f(0, 0, -1), Vec3f(1, 0, 0), Vec3f(0, 0, 1)})
    EXPECT_EQ(lobe.eval(wi), 0);  // fibres along the normal reflect nothing in the last case
}

}  // namespace
}  // namespace emberline
