#include "renderer/shading/lobes/cosine_guide.h"

#include <gtest/gtest.h>

#include "renderer/shading/bsdf.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using test::TestRandom;

// One bright bin in a dark square, and noise.
std::array<float, CosineGuide::kBins> uneven_weights() {
  std::array<float, CosineGuide::kBins> weights;
  TestRandom random(7, 0);
  for (float& weight : weights) weight = 0.2f + random.next();
  weights[37] = 60.0f;
  return weights;
}

TEST(CosineGuide, SamplesHaveItsDensity) {
  const CosineGuide guide(uneven_weights());
  EXPECT_TRUE(test::chi_square_directions(
      [&](TestRandom& random) {
        return std::optional(CosineGuide::direction_of(guide.sample(random.vec2())));
      },
      [&](const Vec3f& w) { return w.z > 0.0f ? double(w.z * kInvPi * guide.density(w)) : 0.0; }));
}

// Surfaces that transmit light are not guided.
TEST(CosineGuide, SurfacesItServes) {
  const Vec3f wo = normalize(Vec3f(0.5f, 0.2f, 0.8f));
  LayerParameters layers;
  layers.clearcoat = 1.0f;
  EXPECT_TRUE(SurfaceBsdf(BsdfParameters(), layers, wo, {0, 0, 1}).can_be_guided());
  layers.diffuse_transmission = 0.5f;
  EXPECT_FALSE(SurfaceBsdf(BsdfParameters(), layers, wo, {0, 0, 1}).can_be_guided());
  BsdfParameters glass;
  glass.transmission = 0.5f;
  EXPECT_FALSE(SurfaceBsdf(glass, wo).can_be_guided());
}

TEST(CosineGuide, KeepsTheOrderOfPoints) {
  const CosineGuide guide(uneven_weights());
  for (const float fixed : {0.0f, 0.3f, kOneMinusEpsilon}) {
    Vec2f before(-1.0f);
    for (int i = 0; i < 1000; ++i) {
      const float moving = float(i) / 1000;
      const Vec2f across = guide.sample({moving, fixed}), up = guide.sample({fixed, moving});
      EXPECT_GE(across.x, before.x);
      EXPECT_GE(up.y, before.y);
      EXPECT_LT(std::max({across.x, across.y, up.x, up.y}), 1.0f);
      before = {across.x, up.y};
    }
  }
}

TEST(CosineGuide, EqualWeightsChangeNothing) {
  std::array<float, CosineGuide::kBins> weights;
  weights.fill(3.0f);
  const CosineGuide guide(weights);
  for (uint64_t i = 0; i < 1000; ++i) {
    const Vec2f u = TestRandom(3, i).vec2();
    const Vec2f guided = guide.sample(u);
    EXPECT_NEAR(guide.density(CosineGuide::direction_of(u)), 1.0f, 1e-5f);
    EXPECT_NEAR(guided.x, u.x, 1e-6f);
    EXPECT_NEAR(guided.y, u.y, 1e-6f);
  }
}

// A guided BSDF samples with the density that it reports, and keeps its value: a plain one, one
// with gloss, and one with layers. The geometric normal cuts off a part of the last two's
// directions.
TEST(CosineGuide, GuidesABsdf) {
  const CosineGuide guide(uneven_weights());
  const Vec3f wo = normalize(Vec3f(0.5f, 0.2f, 0.8f));
  for (const std::string_view kind : {"plain", "gloss", "layers"}) {
    BsdfParameters parameters;
    parameters.roughness = 0.4f;
    parameters.specular = kind == "plain" ? 0.0f : 1.0f;
    LayerParameters layers;
    if (kind == "layers") {
      layers.clearcoat = 0.7f;
      layers.clearcoat_roughness = 0.5f;
      layers.sheen_color = Rgb(0.3f);
      layers.sheen_roughness = 0.6f;
      layers.anisotropy = 0.5f;
    }
    const Vec3f normal = kind == "plain" ? Vec3f(0, 0, 1) : normalize(Vec3f(0.2f, 0.0f, 1.0f));
    const SurfaceBsdf plain = kind == "layers" ? SurfaceBsdf(parameters, layers, wo, normal)
                                               : SurfaceBsdf(parameters, wo, normal);
    ASSERT_TRUE(plain.can_be_guided());
    SurfaceBsdf guided = plain;
    guided.set_guide(&guide);
    EXPECT_TRUE(test::chi_square_directions(
        [&](TestRandom& random) -> std::optional<Vec3f> {
          const float u_lobe = random.next();
          const BsdfSample sample = guided.sample(u_lobe, random.vec2());
          return sample.valid ? std::optional(sample.wi) : std::nullopt;
        },
        [&](const Vec3f& w) {
          float pdf;
          guided.eval_and_pdf(w, &pdf);
          return double(pdf);
        }))
        << kind;
    for (uint64_t i = 0; i < 1000; ++i) {
      const BsdfSample sample = guided.sample(0.5f, TestRandom(5, i).vec2());
      if (!sample.valid) continue;
      EXPECT_EQ(guided.eval(sample.wi), plain.eval(sample.wi));
      float pdf;
      const Rgb value = guided.eval_and_pdf(sample.wi, &pdf);
      EXPECT_NEAR(sample.weight.x * sample.pdf, value.x, 1e-4f * value.x) << i;
    }
  }
}

}  // namespace
}  // namespace emberline
