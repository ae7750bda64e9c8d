// Compares the surface model with closed forms and independent quadrature.

#include "renderer/shading/bsdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderer/core/frame.h"
#include "renderer/core/moments.h"
#include "support/chi_square.h"
#include "support/directions.h"
#include "support/ggx_albedo.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using test::direction;
using test::ggx_albedo;
using test::GgxAlbedo;
using test::TestRandom;

TEST(SpecularAlbedo, DirectQuadratureMeetsTheAnchors) {
  // 1 - ln 2 is exact. For the rest, three methods agree: this one, visible normals, and Monte
  // Carlo.
  const double anchors[][3] = {{.05, 1, .9973}, {.05, .5, .9927}, {.05, .1, .911}, {.1, 1, .9883},
                               {.1, .5, .9694}, {.1, .1, .884},   {.25, 1, .916},  {.25, .5, .857},
                               {.25, .1, .892}, {.5, 1, .6879},   {.5, .5, .698},  {.5, .1, .860},
                               {1, .5, .4505},  {1, .1, .7607}};
  for (const auto& [alpha, mu, e] : anchors)
    EXPECT_NEAR(ggx_albedo(mu, alpha).e, e, 7e-4) << alpha << " " << mu;
  EXPECT_NEAR(ggx_albedo(1, 1).e, 1 - std::log(2.0), 2e-4);
}

TEST(SpecularAlbedo, TablesMeetQuadrature) {
  for (const double alpha : {1.001e-3, 2.2e-3, 0.01, 0.033, 0.1, 0.25, 0.37, 0.5, 0.77, 1.0}) {
    const SpecularAlbedo table(float(std::sqrt(alpha)));
    ASSERT_FALSE(table.is_mirror());
    for (const double mu : {1.0, 0.71, 0.5, 0.23, 0.1, 0.03, 0.01}) {
      const GgxAlbedo exact = ggx_albedo(mu, alpha);
      const SpecularAlbedo::Value value = table.at(float(mu));
      EXPECT_NEAR(1 - double(value.loss), exact.e, 1.2e-3) << "alpha " << alpha << " mu " << mu;
      EXPECT_NEAR(double(value.schlick), exact.b, 1.2e-3) << "alpha " << alpha << " mu " << mu;
    }
  }
}

TEST(SpecularAlbedo, AveragesMatchTheTable) {
  for (float roughness = 0.032f; roughness <= 1.0f; roughness += 0.0137f) {
    const SpecularAlbedo table(roughness);
    double loss = 0, schlick = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {  // mu = t^3 is dense near 0, where smooth surfaces lose energy
      const double t = (i + 0.5) / n, mu = t * t * t;
      const SpecularAlbedo::Value value = table.at(float(mu));
      loss += double(value.loss) * 2 * mu * 3 * t * t / n;
      schlick += double(value.schlick) * 2 * mu * 3 * t * t / n;
    }
    EXPECT_NEAR(double(table.average_loss()) / loss, 1, 5e-3) << roughness;
    EXPECT_NEAR(double(table.average_schlick()), schlick, 1e-4) << roughness;
  }
}

// ---- furnace -----------------------------------------------------------------------------------

float radical_inverse(int base, int i) {
  double value = 0, digit = 1;
  for (++i; i > 0; i /= base) value += (digit /= base) * (i % base);
  return std::min(float(value), kOneMinusEpsilon);
}

// The integral of f L |cos| over directions. Half of the directions are the BSDF's own samples, and
// half are uniform in log(cos) (balance heuristic, Veach & Guibas 1995), so that neither narrow
// lobes nor grazing light make the integral noisy. The points are Hammersley points.
template <typename Radiance>
Rgb reflected(const SurfaceBsdf& bsdf, Radiance radiance, int n = 1 << 14) {
  constexpr double kLogRange = 20;  // down to cos = 2e-9
  double sum[3] = {0, 0, 0};
  const auto log_pdf = [](const Vec3f& wi) {
    return double(wi.z) < std::exp(-kLogRange) ? 0 : 1 / (2 * kPiD * kLogRange * double(wi.z));
  };
  const auto add = [&](const Rgb& value, double scale) {
    for (int c = 0; c < 3; ++c) sum[c] += double(value[c]) * scale;
  };
  for (int i = 0; i < n; ++i) {
    const float a = float((i + .5) / n), b = radical_inverse(2, i), c = radical_inverse(3, i);
    const BsdfSample s = bsdf.sample(a, Vec2f(b, c));
    if (s.valid && s.delta) add(s.weight * radiance(s.wi), 1);
    if (s.valid && !s.delta)
      add(s.weight * radiance(s.wi), double(s.pdf) / (double(s.pdf) + log_pdf(s.wi)));
    const Vec3f wi = direction(float(std::exp(-kLogRange * double(b))), 2 * kPi * c);
    float pdf;
    const Rgb value = bsdf.eval_and_pdf(wi, &pdf);
    add(value * radiance(wi), 1 / (double(pdf) + log_pdf(wi)));
  }
  return Rgb(float(sum[0] / n), float(sum[1] / n), float(sum[2] / n));
}
Rgb furnace(const SurfaceBsdf& bsdf, int n = 1 << 14) {
  return reflected(
      bsdf, [](const Vec3f&) { return 1.0f; }, n);
}

const std::vector<float> kAlphas = {0, 1e-7f, 1e-4f, 1e-3f, .01f, .05f, .1f, .25f, .5f, .8f, 1};
const std::vector<float> kCosines = {1, .5f, .1f, .01f, 1e-3f, 1e-6f};

// A white base absorbs nothing. Energy is conserved for metal, dielectric and every mix of them.
TEST(SurfaceBsdf, WhiteFurnaceReturnsEverything) {
  for (const float alpha : kAlphas)
    for (const float mu : kCosines)
      for (const float metallic : {0.0f, 0.3f, 0.7f, 1.0f}) {
        BsdfParameters p{.base_color = Rgb(1), .metallic = metallic, .roughness = std::sqrt(alpha)};
        const SurfaceBsdf bsdf(p, direction(mu, 0.3f));
        const Rgb got = furnace(bsdf);
        EXPECT_NEAR(got.x, 1, 2e-3)
            << "alpha " << alpha << " mu " << mu << " metallic " << metallic;
        EXPECT_NEAR(bsdf.albedo().x, 1, 1e-4);
      }
}

TEST(SurfaceBsdf, FurnaceEqualsAlbedoForColours) {
  for (const float alpha : {0.0f, .02f, .2f, .7f})
    for (const float mu : {1.0f, .4f, .05f})
      for (const float metallic : {0.0f, .5f, 1.0f})
        for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f, 0.0f}) {
          const BsdfParameters p{.base_color = Rgb(.9f, .3f, 0),
                                 .metallic = metallic,
                                 .roughness = std::sqrt(alpha),
                                 .ior = ior,
                                 .specular = ior == 2.4f    ? .5f
                                             : ior == 1.33f ? 0.0f
                                                            : 1.0f};
          const SurfaceBsdf bsdf(p, direction(mu, 2));
          const Rgb got = furnace(bsdf), want = bsdf.albedo();
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(got[c], want[c], 2e-3)
                << "alpha " << alpha << " mu " << mu << " metallic " << metallic << " ior " << ior;
        }
}

TEST(SurfaceBsdf, NoSpecularIsBareLambert) {
  for (const float roughness : {0.0f, .5f, 1.0f}) {
    const BsdfParameters p{.base_color = Rgb(.6f), .roughness = roughness, .specular = 0};
    const SurfaceBsdf bsdf(p, direction(.2f, 0));
    for (const float mu : {1.0f, .5f, .01f})
      EXPECT_NEAR(bsdf.eval(direction(mu, 3)).x, .6f * kInvPi * mu, 1e-6f);
    EXPECT_NEAR(bsdf.albedo().x, .6f, 1e-6f);
  }
}

// The integral of the specular lobe alone, without compensation, is E.
TEST(SurfaceBsdf, SingleScatterLobeReturnsE) {
  for (const float alpha : {.05f, .25f, 1.0f})
    for (const float mu : {1.0f, .5f, .1f}) {
      const Vec3f wo = direction(mu, 1);
      const GgxReflection lobe(alpha, wo);
      double sum = 0;
      const int n = 512;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const Vec3f wi = lobe.sample(Vec2f((float(i) + .5f) / n, (float(j) + .5f) / n));
          if (!(wi.z > 0)) continue;
          const GgxReflection::Value value = lobe.evaluate(wi);
          EXPECT_LE(value.cosine_brdf, value.pdf * 1.00001f);  // bound of the weight
          sum += double(value.cosine_brdf / value.pdf);
        }
      EXPECT_NEAR(sum / (n * n), ggx_albedo(double(mu), double(alpha)).e, 5e-4);
    }
}

TEST(SurfaceBsdf, BlackMetalAndNothingBehind) {
  // A black metal keeps Schlick's grazing reflection. A surface that is seen from behind absorbs
  // all light.
  const BsdfParameters black{.base_color = Rgb(0), .metallic = 1, .roughness = .5f};
  EXPECT_LT(SurfaceBsdf(black, Vec3f(0, 0, 1)).albedo().x, 1e-3f);
  for (const Vec3f& wo : {direction(-.5f, 0), Vec3f(1, 0, 0), Vec3f(NAN, NAN, NAN)}) {
    const SurfaceBsdf bsdf(BsdfParameters{}, wo);
    EXPECT_FALSE(bsdf.has_non_delta());
    EXPECT_FALSE(bsdf.sample(.3f, Vec2f(.2f, .7f)).valid);
    EXPECT_EQ(bsdf.eval(Vec3f(0, 0, 1)), Rgb(0));
    EXPECT_EQ(test::pdf_of(bsdf, Vec3f(0, 0, 1)), 0);
  }
}

// ---- agreement between value, pdf and sample ---------------------------------------------------

BsdfParameters random_parameters(TestRandom& random) {
  BsdfParameters p;
  p.base_color = Rgb(random.next(), random.next(), random.next());
  p.metallic = std::clamp(random.next() * 1.4f - .2f, 0.0f, 1.0f);
  p.roughness = random.next();
  p.ior = 1 + random.next() * 1.5f;
  if (random.next() < .3f) p.specular = random.next();
  if (random.next() < .1f) p.specular = 0;
  return p;
}

TEST(SurfaceBsdf, IsReciprocal) {
  for (uint64_t i = 0; i < 20000; ++i) {
    TestRandom random(7, i);
    BsdfParameters p = random_parameters(random);
    p.roughness = .15f + .85f * p.roughness;
    const Vec3f a = direction(.01f + .99f * random.next(), 6.28f * random.next());
    const Vec3f b = direction(.01f + .99f * random.next(), 6.28f * random.next());
    const Rgb ab = SurfaceBsdf(p, a).eval(b) / b.z, ba = SurfaceBsdf(p, b).eval(a) / a.z;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(ab[c], ba[c], 1e-4f * (1 + ab[c])) << "draw " << i;
  }
}

TEST(SurfaceBsdf, SamplesFollowTheDensity) {
  struct Case {
    float metallic, alpha, mu;
    Vec3f ng;
  };
  const Vec3f up(0, 0, 1), bent = direction(std::cos(.4f), 2.5f);
  const Case cases[] = {{0, .3f, .8f, up},    {1, .3f, .8f, up},  {.5f, 1, .3f, up},
                        {.5f, .1f, .1f, up},  {1, .05f, .9f, up}, {0, .6f, 1e-3f, up},
                        {.5f, .3f, .6f, bent}};
  for (const Case& c : cases) {
    const BsdfParameters p{
        .base_color = Rgb(.8f, .5f, .2f), .metallic = c.metallic, .roughness = std::sqrt(c.alpha)};
    const SurfaceBsdf bsdf(p, direction(c.mu, .7f), c.ng);
    EXPECT_TRUE(test::chi_square_directions(
        [&](TestRandom& random) -> std::optional<Vec3f> {
          const float lobe = random.next();
          const BsdfSample s = bsdf.sample(lobe, random.vec2());
          if (!s.valid) return std::nullopt;
          return s.wi;
        },
        [&](const Vec3f& wi) { return double(test::pdf_of(bsdf, wi)); },
        {.samples = 200'000, .tests = int(std::size(cases))}, 0))
        << "metallic " << c.metallic << " alpha " << c.alpha << " mu " << c.mu;
  }
}

// The parameters and directions are arbitrary and include narrow lobes and grazing angles. Values
// are finite and non-negative, and samples agree with eval and pdf.
TEST(SurfaceBsdf, SweepStaysFiniteAndConsistent) {
  const float roughnesses[] = {0, 3e-4f, .0316f, .0317f, .05f, .2f, 1};
  const float cosines[] = {1e-38f, 1e-20f, 1e-6f, 1e-4f, .05f, 1};
  double largest = 0;
  for (uint64_t i = 0; i < 400000; ++i) {
    TestRandom random(3, i);
    BsdfParameters p = random_parameters(random);
    if (random.next() < .5f) p.roughness = roughnesses[random.bits() % 7];
    if (random.next() < .2f) p.base_color = Rgb(float(random.bits() & 1));
    if (random.next() < .1f) p.ior = random.next() < .5f ? 0.0f : 1.0f;
    const auto cosine = [&] {
      return random.next() < .3f ? cosines[random.bits() % 6] : random.next();
    };
    const Vec3f wo = direction(cosine(), 6.28f * random.next());
    Vec3f ng(0, 0, 1);
    if (random.next() < .3f) {
      ng = direction(random.next(), 6.28f * random.next());
      if (dot(ng, wo) < 0) ng = Vec3f(0, 0, 1);
    }
    const SurfaceBsdf bsdf(p, wo, ng);
    const float lobe = random.next();
    const BsdfSample s = bsdf.sample(lobe, random.vec2());
    const Vec3f other = direction(cosine(), 6.28f * random.next());
    float pdf = 0;
    const Rgb value = bsdf.eval_and_pdf(other, &pdf);
    ASSERT_TRUE(is_finite(value) && std::isfinite(pdf)) << "draw " << i;
    ASSERT_TRUE(value.x >= 0 && value.y >= 0 && value.z >= 0 && pdf >= 0) << "draw " << i;
    ASSERT_NEAR(test::pdf_of(bsdf, other), pdf, 1e-5f * pdf) << "draw " << i;
    if (!s.valid) continue;
    ASSERT_TRUE(is_finite(s.weight) && is_finite(s.wi)) << "draw " << i;
    ASSERT_NEAR(dot(s.wi, s.wi), 1, 1e-5f) << "draw " << i;
    ASSERT_TRUE(s.wi.z > 0 && dot(s.wi, ng) > 0) << "draw " << i;
    largest = std::max(largest, double(max_component(s.weight)));
    if (s.delta) continue;
    ASSERT_GT(s.pdf, 0) << "draw " << i;
    ASSERT_NEAR(test::pdf_of(bsdf, s.wi), s.pdf, 1e-4f * s.pdf) << "draw " << i;
    const Rgb eval = bsdf.eval(s.wi);
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(s.weight[c] * s.pdf, eval[c], 1e-4f * eval[c] + 1e-7f) << "draw " << i;
  }
  EXPECT_LT(largest, 12) << "a sample's weight is bounded";
}

// Above and below the limit at which a narrow lobe becomes a mirror, a gradient looks the same.
TEST(SurfaceBsdf, NarrowLobesMeetTheMirror) {
  const auto gradient = [](const Vec3f& w) { return 1 + .5f * w.x + .3f * w.y + .2f * w.z; };
  for (const float metallic : {0.0f, 1.0f})
    for (const float mu : {1.0f, .5f, .1f}) {
      BsdfParameters p{.base_color = Rgb(.7f), .metallic = metallic};
      p.roughness = std::sqrt(kMirrorAlpha) * 1.001f;
      const SurfaceBsdf narrow(p, direction(mu, 1));
      p.roughness = 1e-4f;
      const SurfaceBsdf mirror(p, direction(mu, 1));
      ASSERT_TRUE(narrow.has_non_delta());
      EXPECT_EQ(mirror.has_non_delta(), metallic < 1);
      EXPECT_NEAR(reflected(narrow, gradient).x, reflected(mirror, gradient).x, 1e-3f)
          << "metallic " << metallic << " mu " << mu;
    }
}

TEST(SurfaceBsdf, MirrorReflectsByTheMirrorLaw) {
  const Vec3f wo = direction(.6f, 1);
  const SurfaceBsdf bsdf(BsdfParameters{.base_color = Rgb(1), .metallic = 1, .roughness = 0}, wo);
  const BsdfSample s = bsdf.sample(.999f, Vec2f(.1f, .2f));
  ASSERT_TRUE(s.valid && s.delta);
  EXPECT_EQ(s.wi, Vec3f(-wo.x, -wo.y, wo.z));
  EXPECT_EQ(s.pdf, 0);
  EXPECT_NEAR(s.weight.x, 1, 1e-6);
  EXPECT_EQ(test::pdf_of(bsdf, s.wi), 0);
}

TEST(BranchFree, SincosTurnsIsAccurate) {
  for (int i = 0; i <= 1 << 16; ++i) {
    const float u = float(i) * 0x1p-16f;
    float sine, cosine;
    sincos_turns(u, &sine, &cosine);
    EXPECT_NEAR(double(sine), std::sin(2 * kPiD * double(u)), 2e-7);
    EXPECT_NEAR(double(cosine), std::cos(2 * kPiD * double(u)), 2e-7);
  }
}

}  // namespace
}  // namespace emberline
