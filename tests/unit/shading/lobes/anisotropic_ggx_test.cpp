// Compares the anisotropic lobe with the isotropic lobe, closed forms and independent quadrature.
#include "renderer/shading/lobes/anisotropic_ggx.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/shading/lobes/ggx.h"
#include "support/chi_square.h"
#include "support/directions.h"
#include "support/ggx_albedo.h"

namespace emberline {
namespace {

using test::direction;
using test::ggx_albedo;
using test::GgxAlbedo;
using test::TestRandom;

TEST(AnisotropicGgx, EqualWidthsAreTheIsotropicLobe) {
  for (uint64_t i = 0; i < 20000; ++i) {
    TestRandom random(61, i);
    const float alpha = kMirrorAlpha + (1 - kMirrorAlpha) * square(random.next());
    const Vec3f wo = direction(random.next() + 1e-6f, 6.28f * random.next());
    const GgxReflection one(alpha, wo);
    const AnisotropicGgx two(alpha, alpha, wo);
    const Vec2f u = random.vec2();
    const Vec3f a = one.sample(u), b = two.sample(u);
    ASSERT_LT((a - b).length(), 1e-5f) << i;
    if (!(a.z > 1e-3f)) continue;
    const GgxReflection::Value va = one.evaluate(a);
    const AnisotropicGgx::Value vb = two.evaluate(a);
    ASSERT_NEAR(vb.pdf, va.pdf, 1e-4f * va.pdf) << i;
    ASSERT_NEAR(vb.cosine_brdf, va.cosine_brdf, 1e-4f * va.cosine_brdf) << i;
    ASSERT_NEAR(vb.cos_d, va.cos_d, 1e-6f) << i;
  }
}

TEST(AnisotropicGgx, IsReciprocal) {
  for (uint64_t i = 0; i < 20000; ++i) {
    TestRandom random(62, i);
    const float ay = .03f + .97f * random.next(), ax = .03f + .97f * random.next();
    const Vec3f a = direction(.01f + .99f * random.next(), 6.28f * random.next());
    const Vec3f b = direction(.01f + .99f * random.next(), 6.28f * random.next());
    const float ab = AnisotropicGgx(ax, ay, a).evaluate(b).cosine_brdf / b.z;
    const float ba = AnisotropicGgx(ax, ay, b).evaluate(a).cosine_brdf / a.z;
    ASSERT_NEAR(ab, ba, 1e-4f * ab) << "draw " << i;
  }
}

TEST(AnisotropicGgx, SamplesFollowTheDensity) {
  struct Case {
    float ax, ay, mu, phi;
  };
  const Case cases[] = {{1, .1f, 1, 0},        {1, .1f, .5f, 0},   {1, .1f, .5f, 1.5f},
                        {.5f, .2f, .1f, .7f},  {.3f, .1f, .8f, 4}, {.2f, .6f, .3f, 2},
                        {1, .5f, 1e-3f, 1.57f}};
  for (const Case& c : cases) {
    const AnisotropicGgx lobe(c.ax, c.ay, direction(c.mu, c.phi));
    EXPECT_TRUE(test::chi_square_directions(
        [&](TestRandom& random) -> std::optional<Vec3f> {
          const Vec3f wi = lobe.sample(random.vec2());
          if (!(wi.z > 0)) return std::nullopt;
          return wi;
        },
        [&](const Vec3f& wi) { return wi.z > 0 ? double(lobe.evaluate(wi).pdf) : 0; },
        {.samples = 200'000, .seed = 63, .tests = int(std::size(cases))}, 0))
        << "alpha " << c.ax << " " << c.ay << " mu " << c.mu << " phi " << c.phi;
  }
}

// The lobes are narrow in one direction, so the bins are in the slopes of the half vector, in units
// of alpha (compare sampling_routines_test.cpp).
TEST(AnisotropicGgx, NarrowLobesFollowTheDensityInSlopes) {
  struct Case {
    float ax, ay, mu, phi;
  };
  const Case cases[] = {{.02f, 1e-3f, .9f, .5f}, {.2f, .01f, .5f, 1.2f}, {.05f, .01f, .2f, 3}};
  for (const Case& c : cases) {
    const Vec3f wo = direction(c.mu, c.phi);
    const AnisotropicGgx lobe(c.ax, c.ay, wo);
    EXPECT_TRUE(test::chi_square_test(
        [&](TestRandom& random) -> std::optional<test::ChiSquarePoint> {
          const Vec3f wi = lobe.sample(random.vec2());
          const Vec3d h = Vec3d(wo) + Vec3d(wi);
          const test::ChiSquarePoint p{h.x / h.z / double(c.ax), h.y / h.z / double(c.ay), 1};
          if (!(wi.z > 0) || std::abs(p.x) > 4 || std::abs(p.y) > 4) return std::nullopt;
          return p;
        },
        [&](double x, double y) {
          Vec3d h(x * double(c.ax), y * double(c.ay), 1);
          h /= std::sqrt(dot(h, h));
          const double cos_d = dot(Vec3d(wo), h);
          const Vec3d wi = h * (2 * cos_d) - Vec3d(wo);
          if (!(cos_d > 0) || !(wi.z > 0)) return 0.0;
          return double(lobe.evaluate(Vec3f(wi)).pdf) * 4 * cos_d * square(h.z) * h.z *
                 double(c.ax * c.ay);
        },
        {-4, 4, -4, 4}, {.samples = 200'000, .seed = 64, .tests = int(std::size(cases))}))
        << "alpha " << c.ax << " " << c.ay << " mu " << c.mu << " phi " << c.phi;
  }
}

TEST(AnisotropicGgx, SamplesReturnTheAlbedoWithBoundedWeights) {
  const float cases[][4] = {{1, .1f, .5f, 0},   {1, .1f, .5f, 1.57f}, {1, .01f, .2f, 1},
                            {.4f, .2f, .1f, 2}, {.3f, .002f, .9f, 1}, {1, 1, 1, 0}};
  for (const auto& [ax, ay, mu, phi] : cases) {
    const Vec3f wo = direction(mu, phi);
    const AnisotropicGgx lobe(ax, ay, wo);
    double sum = 0;
    const int n = 512;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const Vec3f wi = lobe.sample(Vec2f((float(i) + .5f) / n, (float(j) + .5f) / n));
        if (!(wi.z > 0)) continue;
        const AnisotropicGgx::Value value = lobe.evaluate(wi);
        EXPECT_LE(value.cosine_brdf, value.pdf * 1.0001f);
        sum += double(value.cosine_brdf / value.pdf);
      }
    EXPECT_NEAR(sum / (n * n), ggx_albedo(to_double(wo), double(ax), double(ay), 500).e, 7e-4)
        << ax << " " << ay << " " << mu << " " << phi;
  }
  EXPECT_NEAR(ggx_albedo(Vec3d(0, 0, 1), 1, 1, 500).e, 1 - std::log(2.0), 2e-4);  // exact
}

TEST(AnisotropicGgx, SweepStaysFinite) {
  const float cosines[] = {1e-38f, 1e-20f, 1e-6f, 1e-4f, .05f, 1};
  const float alphas[] = {kMirrorAlpha, 2e-3f, .1f, 1};
  for (uint64_t i = 0; i < 200000; ++i) {
    TestRandom random(65, i);
    const auto cosine = [&] {
      return random.next() < .3f ? cosines[random.bits() % 6] : random.next();
    };
    const auto alpha = [&] {
      return random.next() < .3f ? alphas[random.bits() % 4]
                                 : kMirrorAlpha + (1 - kMirrorAlpha) * random.next();
    };
    const float ax = alpha(), ay = alpha();
    const Vec3f wo = direction(cosine(), 6.28f * random.next());
    const AnisotropicGgx lobe(ax, ay, wo);
    const Vec3f s = lobe.sample(random.vec2());
    ASSERT_NEAR(dot(s, s), 1, 1e-5f) << i;
    for (const Vec3f& wi : {s, direction(cosine(), 6.28f * random.next())}) {
      if (!(wi.z > 0)) continue;
      const AnisotropicGgx::Value value = lobe.evaluate(wi);
      ASSERT_TRUE(std::isfinite(value.cosine_brdf) && value.cosine_brdf >= 0) << i;
      ASSERT_TRUE(std::isfinite(value.pdf) && value.pdf > 0) << i;
      ASSERT_TRUE(value.cos_d >= 0 && value.cos_d <= 1) << i;
    }
    const SpecularAlbedo::Value albedo =
        AnisotropicAlbedo(std::max(ax, ay), std::min(ax, ay)).at(wo);
    ASSERT_TRUE(albedo.loss >= 0 && albedo.loss <= 1) << i;
    ASSERT_TRUE(albedo.schlick >= 0 && albedo.schlick <= 1) << i;
  }
}

// ---- albedo ------------------------------------------------------------------------------------

TEST(AnisotropicAlbedo, EqualWidthsAreTheIsotropicTable) {
  for (uint64_t i = 0; i < 5000; ++i) {
    TestRandom random(66, i);
    const float roughness = std::sqrt(kMirrorAlpha) * 1.00001f + .968f * random.next();
    const float alpha = square(roughness), mu = random.next() * random.next();
    const SpecularAlbedo one(roughness);
    const AnisotropicAlbedo two(alpha, alpha);
    const SpecularAlbedo::Value a = one.at(mu), b = two.at(direction(mu, 6.28f * random.next()));
    ASSERT_NEAR(b.loss, a.loss, 1e-5f) << i;
    ASSERT_NEAR(b.schlick, a.schlick, 1e-5f) << i;
    ASSERT_NEAR(two.average_loss(), one.average_loss(), 1e-5f) << i;
    ASSERT_NEAR(two.average_schlick(), one.average_schlick(), 1e-5f) << i;
  }
}

TEST(AnisotropicAlbedo, MeetsQuadrature) {
  double largest_e = 0, largest_b = 0, squares = 0;
  const int n = 250;
  for (uint64_t i = 0; i < n; ++i) {
    TestRandom random(67, i);
    const float strength = random.next();
    const float ay = std::max(kMirrorAlpha, square(random.next()));
    const float ax = ay + (1 - ay) * square(strength);  // as in glTF
    const float mu = i % 2 ? random.next() : std::max(.01f, square(random.next()));
    const Vec3f w = direction(mu, 6.2831853f * (i % 3 ? random.next() : .25f));
    const GgxAlbedo want = ggx_albedo(to_double(w), double(ax), double(ay), 300);
    const SpecularAlbedo::Value got = AnisotropicAlbedo(ax, ay).at(w);
    const double e = std::abs(1 - double(got.loss) - want.e);
    const double b = std::abs(double(got.schlick) - want.b);
    EXPECT_LT(e, 1.5e-3) << "alpha " << ax << " " << ay << " mu " << mu << " w " << w;
    EXPECT_LT(b, 1.5e-3) << "alpha " << ax << " " << ay << " mu " << mu << " w " << w;
    largest_e = std::max(largest_e, e);
    largest_b = std::max(largest_b, b);
    squares += e * e / n;
  }
  std::printf("largest error of E %.2e (rms %.2e), of B %.2e\n", largest_e, std::sqrt(squares),
              largest_b);
}

TEST(AnisotropicAlbedo, AveragesMatchTheTable) {
  for (uint64_t i = 0; i < 40; ++i) {
    TestRandom random(68, i);
    const float ay = std::max(kMirrorAlpha, square(random.next()));
    const float ax = ay + (1 - ay) * square(random.next());
    const AnisotropicAlbedo table(ax, ay);
    double loss = 0, schlick = 0;
    const int n = 300, turns = 200;
    for (int a = 0; a < n; ++a) {
      const double t = (a + .5) / n, mu = t * t * t;  // nodes where smooth surfaces lose energy
      for (int p = 0; p < turns; ++p) {
        // phi = pi/2 (1 - s^2) puts nodes where an anisotropic lobe is narrow.
        const double s = (p + .5) / turns, phi = kPiD / 2 * (1 - s * s);
        const SpecularAlbedo::Value value = table.at(direction(float(mu), float(phi)));
        const double weight = 2 * mu * 3 * t * t / n * 2 * s / turns;
        loss += double(value.loss) * weight;
        schlick += double(value.schlick) * weight;
      }
    }
    EXPECT_NEAR(double(table.average_loss()), loss, 1e-2 * loss + 2e-4) << ax << " " << ay;
    EXPECT_NEAR(double(table.average_schlick()), schlick, 5e-4) << ax << " " << ay;
  }
}

}  // namespace
}  // namespace emberline
