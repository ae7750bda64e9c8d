// Tests the list of lobes: layers on the base, thin films, anisotropic highlights, diffuse
// transmission.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "renderer/shading/bsdf.h"
#include "renderer/shading/lobes/thin_film.h"
#include "support/chi_square.h"
#include "support/directions.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using test::direction;
using test::TestRandom;

const Vec3f kUp(0, 0, 1);

struct Material {
  std::string name;
  BsdfParameters base;
  LayerParameters layers;

  SurfaceBsdf at(const Vec3f& wo, const Vec3f& ng = kUp) const { return {base, layers, wo, ng}; }
};

Material white(const char* name, float metallic, float roughness) {
  Material m;
  m.name = name;
  m.base.base_color = Rgb(1);
  m.base.metallic = metallic;
  m.base.roughness = roughness;
  return m;
}

double radical_inverse(int base, int i) {
  double value = 0, digit = 1;
  for (++i; i > 0; i /= base) value += (digit /= base) * (i % base);
  return value;
}

// The integral of f |cos| over the sphere. Half of the directions are the BSDF's own samples, and
// half are uniform in the cosine of each hemisphere (balance heuristic). The points are Hammersley
// points.
Rgb furnace(const SurfaceBsdf& bsdf, int n = 1 << 14) {
  double sum[3] = {0, 0, 0};
  const auto add = [&](const Rgb& value, double scale) {
    for (int c = 0; c < 3; ++c) sum[c] += double(value[c]) * scale;
  };
  for (int i = 0; i < n; ++i) {
    const auto a = float((i + .5) / n), b = float(radical_inverse(2, i)),
               c = float(radical_inverse(3, i)), d = float(radical_inverse(5, i));
    const auto even = [](const Vec3f& w) { return std::abs(double(w.z)) / (2 * kPiD); };
    const BsdfSample s = bsdf.sample(a, Vec2f(b, c));
    if (s.valid) add(s.weight, s.delta ? 1 : double(s.pdf) / (double(s.pdf) + even(s.wi)));
    Vec3f wi = direction(std::sqrt(b), 2 * kPi * c);
    if (d < .5f) wi.z = -wi.z;
    float pdf;
    const Rgb value = bsdf.eval_and_pdf(wi, &pdf);
    if (even(wi) > 0) add(value, 1 / (double(pdf) + even(wi)));
  }
  return {float(sum[0] / n), float(sum[1] / n), float(sum[2] / n)};
}

const std::vector<float> kCosines = {1, .7f, .3f, .1f, .02f};

TEST(LayeredBsdf, WithoutLayersIsThePlainModel) {
  for (uint64_t i = 0; i < 2000; ++i) {
    TestRandom random(1, i);
    Material m = white("", random.next(), random.next());
    m.base.base_color = Rgb(random.next(), random.next(), random.next());
    m.base.specular_color = Rgb(random.next(), 2 * random.next(), random.next());
    const Vec3f wo = direction(random.next(), 1), wi = direction(random.next(), 6 * random.next());
    const Rgb plain = SurfaceBsdf(m.base, wo).eval(wi), list = m.at(wo).eval(wi);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(plain[c], list[c], 1e-5f * (1 + plain[c])) << i;
  }
}

// A white material without absorption returns all light. The tolerance is 2e-3, plus the error of
// the table if the material is anisotropic.
TEST(LayeredBsdf, WhiteFurnaceReturnsEverything) {
  std::vector<Material> materials;
  for (const float roughness : {0.0f, .2f, .5f, 1.0f}) {
    for (const float metallic : {0.0f, .5f, 1.0f}) {
      for (const float strength : {.3f, .7f, 1.0f}) {
        materials.push_back(white("stretched", metallic, roughness));
        materials.back().layers.anisotropy = strength;
        materials.back().layers.anisotropy_direction = Vec2f(.6f, .8f);
      }
    }
    materials.push_back(white("diffuse transmission", 0, roughness));
    materials.back().layers.diffuse_transmission = .7f;
    // A coat over a Lambertian lobe, or over a mirror, conserves energy.
    for (const float coat : {.4f, 1.0f}) {
      materials.push_back(white("coat on Lambert", 0, 1));
      materials.back().base.specular = 0;
      materials.back().layers.clearcoat = coat;
      materials.back().layers.clearcoat_roughness = roughness;
      materials.push_back(white("coat on a mirror", 1, 0));
      materials.back().layers.clearcoat = coat;
      materials.push_back(white("sheen on Lambert", 0, 1));
      materials.back().base.specular = 0;
      materials.back().layers.sheen_color = Rgb(coat);
      materials.back().layers.sheen_roughness = std::max(.1f, roughness);
    }
  }
  for (const Material& m : materials) {
    for (const float mu : kCosines) {
      const Rgb got = furnace(m.at(direction(mu, .3f)));
      EXPECT_NEAR(got.x, 1, 2e-3) << m.name << ", roughness " << m.base.roughness << ", metallic "
                                  << m.base.metallic << ", strength " << m.layers.anisotropy
                                  << ", coat " << m.layers.clearcoat << " of roughness "
                                  << m.layers.clearcoat_roughness << ", mu " << mu;
    }
  }
}

// Any stack of white layers returns no more than it receives, and not much less.
TEST(LayeredBsdf, StacksNeverReturnMoreThanTheyGet) {
  double least = 1;
  int i = 0;
  for (const float metallic : {0.0f, 1.0f})
    for (const float roughness : {0.0f, .3f, 1.0f})
      for (const float coat : {0.0f, 1.0f})
        for (const float sheen : {0.0f, 1.0f})
          for (const float transmission : {0.0f, .5f, 1.0f})
            for (const float film : {0.0f, 1.0f})
              for (const float mu : {1.0f, .4f, .05f}) {
                Material m = white("", metallic, roughness);
                m.base.transmission = transmission;
                m.layers.clearcoat = coat;
                m.layers.clearcoat_roughness = .5f * float(++i % 3);
                m.layers.sheen_color = Rgb(sheen);
                m.layers.sheen_roughness = .3f + .35f * float(i % 3);
                m.layers.iridescence = film;
                m.layers.iridescence_thickness = 100.0f * float(i % 9);
                m.layers.diffuse_transmission = .5f * float(i % 2);
                m.layers.anisotropy = .4f * float(i % 3);
                const double got =
                    double(max_component(furnace(m.at(direction(mu, .3f)), 1 << 12)));
                least = std::min(least, got);
                ASSERT_LT(got, 1.004)
                    << "metallic " << metallic << " roughness " << roughness << " coat " << coat
                    << " of " << m.layers.clearcoat_roughness << " sheen " << sheen
                    << " transmission " << transmission << " film " << film << " of "
                    << m.layers.iridescence_thickness << " stretched " << m.layers.anisotropy
                    << " mu " << mu;
              }
  RecordProperty("least", std::to_string(least));
  EXPECT_GT(least, .5);
}

// Materials with each kind of layer alone and with all of them together. Clear transmission is left
// out, because it is not reciprocal.
std::vector<Material> kinds() {
  std::vector<Material> list;
  const auto add = [&](const char* name, const auto& change) {
    Material m = white(name, 0, .5f);
    m.base.base_color = Rgb(.9f, .5f, .2f);
    change(m.base, m.layers);
    list.push_back(m);
  };
  using B = BsdfParameters;
  using L = LayerParameters;
  add("coat", [](B&, L& l) { l.clearcoat = 1, l.clearcoat_roughness = .3f; });
  add("tilted coat", [](B&, L& l) {
    l.clearcoat = .8f, l.clearcoat_roughness = .5f, l.clearcoat_normal = direction(.95f, 2);
  });
  add("sheen", [](B&, L& l) { l.sheen_color = Rgb(.9f, .3f, .5f), l.sheen_roughness = .4f; });
  add("stretched metal", [](B& b, L& l) {
    b.metallic = 1, l.anisotropy = .8f, l.anisotropy_direction = Vec2f(.6f, -.8f);
  });
  add("film on metal",
      [](B& b, L& l) { b.metallic = 1, l.iridescence = 1, l.iridescence_thickness = 420; });
  add("film on a dielectric", [](B&, L& l) { l.iridescence = .7f, l.iridescence_thickness = 300; });
  add("diffuse transmission", [](B&, L& l) {
    l.diffuse_transmission = .6f, l.diffuse_transmission_color = Rgb(.3f, .9f, .5f);
  });
  add("tinted reflection", [](B& b, L&) { b.specular_color = Rgb(3, 1, .2f); });
  add("all", [](B& b, L& l) {
    b.metallic = .3f;
    l = {.anisotropy = .5f,
         .anisotropy_direction = Vec2f(0, 1),
         .iridescence = .5f,
         .iridescence_ior = 1.5f,
         .iridescence_thickness = 500,
         .diffuse_transmission = .4f,
         .diffuse_transmission_color = Rgb(.8f),
         .sheen_color = Rgb(.3f),
         .sheen_roughness = .5f,
         .clearcoat = .5f,
         .clearcoat_roughness = .4f};
  });
  return list;
}

TEST(LayeredBsdf, IsReciprocal) {
  for (const Material& m : kinds()) {
    if (m.layers.clearcoat_normal.z < 1) continue;  // a tilted coat has its own cosine
    for (uint64_t i = 0; i < 4000; ++i) {
      TestRandom random(2, i);
      const Vec3f a = direction(.02f + .98f * random.next(), 6.28f * random.next());
      Vec3f b = direction(.02f + .98f * random.next(), 6.28f * random.next());
      const bool below = m.layers.diffuse_transmission > 0 && random.next() < .5f;
      const Vec3f other = below ? Vec3f(b.x, b.y, -b.z) : b;
      const Rgb ab = m.at(a).eval(other) / b.z;
      // Seen from the other side, the surface is mirrored: its normal is reversed, and x and y
      // stay.
      const Rgb ba = below ? m.at(b).eval(Vec3f(a.x, a.y, -a.z)) / a.z : m.at(b).eval(a) / a.z;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(ab[c], ba[c], 2e-4f * (1 + ab[c])) << m.name << " draw " << i;
    }
  }
}

TEST(LayeredBsdf, SamplesFollowTheDensity) {
  std::vector<Material> materials = kinds();
  Material glass = white("coated rough glass", 0, .5f);
  glass.base.transmission = .7f;
  glass.base.thin_walled = false;
  glass.layers.clearcoat = 1;
  glass.layers.clearcoat_roughness = .6f;
  glass.layers.iridescence = 1;
  glass.layers.iridescence_thickness = 350;
  materials.push_back(glass);
  glass.name = "the same from inside";
  glass.base.inside = glass.layers.behind = true;
  materials.push_back(glass);
  const Vec3f bent = direction(std::cos(.3f), 2.5f);
  for (const Material& m : materials) {
    for (const Vec3f& ng : {kUp, bent}) {
      const SurfaceBsdf bsdf = m.at(direction(.6f, .7f), ng);
      EXPECT_TRUE(test::chi_square_directions(
          [&](TestRandom& random) -> std::optional<Vec3f> {
            const float lobe = random.next();
            const BsdfSample s = bsdf.sample(lobe, random.vec2());
            if (!s.valid || s.delta) return std::nullopt;
            return s.wi;
          },
          [&](const Vec3f& wi) { return double(test::pdf_of(bsdf, wi)); },
          {.samples = 200'000, .tests = 2 * int(materials.size())}, -1))
          << m.name;
    }
  }
}

// The parameters and directions are arbitrary. Values are finite and non-negative, and samples
// agree with eval and pdf.
TEST(LayeredBsdf, SweepStaysFiniteAndConsistent) {
  double largest = 0;
  for (uint64_t i = 0; i < 200000; ++i) {
    TestRandom random(3, i);
    const auto often = [&](float share) { return random.next() < share; };
    const auto unit = [&] { return often(.2f) ? float(random.bits() & 1) : random.next(); };
    Material m = white("", unit(), unit());
    m.base.base_color = Rgb(unit(), unit(), unit());
    m.base.ior = often(.1f) ? float(random.bits() & 1) : 1 + 2 * random.next();
    m.base.specular = unit();
    m.base.specular_color = Rgb(unit(), 3 * unit(), unit());
    m.base.transmission = often(.4f) ? unit() : 0;
    m.base.thin_walled = often(.5f);
    m.base.inside = often(.3f);
    m.layers.behind = often(.3f);
    LayerParameters& l = m.layers;
    if (often(.5f)) l.anisotropy = unit(), l.anisotropy_direction = Vec2f(.6f, .8f);
    if (often(.3f)) l.iridescence = unit(), l.iridescence_ior = 1 + 2 * unit();
    l.iridescence_thickness = 1000 * unit();
    if (often(.3f)) l.diffuse_transmission = unit();
    if (often(.5f)) l.sheen_color = Rgb(unit(), unit(), unit()), l.sheen_roughness = unit();
    if (often(.5f)) l.clearcoat = unit(), l.clearcoat_roughness = unit();
    if (often(.3f)) l.clearcoat_normal = direction(random.next(), 6 * random.next());
    const float cosines[] = {1e-38f, 1e-20f, 1e-6f, 1e-4f, .05f, 1};
    const auto cosine = [&] { return often(.3f) ? cosines[random.bits() % 6] : random.next(); };
    const Vec3f wo = direction(cosine(), 6.28f * random.next());
    Vec3f ng = kUp;
    if (often(.3f)) ng = direction(random.next(), 6.28f * random.next());
    if (dot(ng, wo) < 0) ng = kUp;
    const SurfaceBsdf bsdf = m.at(wo, ng);
    Vec3f other = direction(cosine(), 6.28f * random.next());
    if (often(.3f)) other.z = -other.z;
    float pdf = 0;
    const Rgb value = bsdf.eval_and_pdf(other, &pdf);
    ASSERT_TRUE(is_finite(value) && std::isfinite(pdf)) << "draw " << i;
    ASSERT_TRUE(value.x >= 0 && value.y >= 0 && value.z >= 0 && pdf >= 0) << "draw " << i;
    ASSERT_TRUE(is_finite(bsdf.albedo())) << "draw " << i;
    if (!is_black(value)) {
      ASSERT_TRUE(bsdf.has_non_delta()) << "draw " << i;
      ASSERT_TRUE(other.z > 0 || bsdf.transmits_non_delta()) << "draw " << i;
    }
    const float lobe = random.next();
    const BsdfSample s = bsdf.sample(lobe, random.vec2());
    if (!s.valid) continue;
    ASSERT_TRUE(is_finite(s.weight) && is_finite(s.wi)) << "draw " << i;
    ASSERT_NEAR(dot(s.wi, s.wi), 1, 1e-5f) << "draw " << i;
    ASSERT_EQ(s.transmitted, s.wi.z < 0) << "draw " << i;
    largest = std::max(largest, double(max_component(s.weight) * s.eta_scale));
    if (s.delta) continue;
    ASSERT_GT(s.pdf, 0) << "draw " << i;
    ASSERT_NEAR(test::pdf_of(bsdf, s.wi), s.pdf, 1e-4f * s.pdf) << "draw " << i;
    const Rgb eval = bsdf.eval(s.wi);
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(s.weight[c] * s.pdf, eval[c], 1e-4f * eval[c] + 1e-7f) << "draw " << i;
  }
  EXPECT_LT(largest, 40) << "a sample's weight is bounded";
}

// A coat reduces the sampling of smooth glass by the light that it blocks. Partial glass is sampled
// with its own weight.
TEST(LayeredBsdf, SmoothGlassIsSampledWithItsWeight) {
  const Vec3f wo = direction(.9f, 1);
  const auto passed = [&](const Material& m) {
    const SurfaceBsdf bsdf = m.at(wo);
    double sum = 0;
    for (int i = 0; i < 1000; ++i) {
      const BsdfSample s = bsdf.sample((float(i) + .5f) / 1000, Vec2f(.3f, .6f));
      if (s.valid && s.transmitted) sum += double(s.weight.x) / 1000;
    }
    return sum;
  };
  Material glass = white("", 0, 0);
  glass.base.transmission = 1;
  glass.base.thin_walled = false;
  glass.base.inside = glass.layers.behind = true;
  const double bare = passed(glass);
  glass.layers.clearcoat = 1;
  // The ray leaves at the refracted cosine. A smooth coat transmits 1 - F by Schlick.
  const float sine2 = (1 - .9f * .9f) * square(1.5f);
  const float mu = std::sqrt(1 - sine2), m = 1 - mu;
  EXPECT_NEAR(passed(glass) / bare, .96 * (1 - double(m * m * m * m * m)), 1e-3);

  Material half = white("", 0, 0);
  half.base.base_color = Rgb(1);
  half.base.specular = 0;
  half.base.transmission = 1;
  const double all = passed(half);
  half.base.transmission = .5f;
  half.base.base_color = Rgb(.25f);
  EXPECT_NEAR(passed(half) / all, .5 * .25, 1e-3);
}

TEST(LayeredBsdf, FilmOfZeroThicknessHasNoEffect) {
  for (const float metallic : {0.0f, 1.0f}) {
    Material m = white("", metallic, .4f);
    m.base.base_color = Rgb(.9f, .5f, .2f);
    const Vec3f wo = direction(.5f, 1), wi = direction(.7f, 4);
    const Rgb none = m.at(wo).eval(wi);
    m.layers.iridescence = 1;
    const Rgb film = m.at(wo).eval(wi);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(film[c], none[c], .02f * none[c] + 1e-3f) << metallic;
  }
}

// A mirror's colour at normal incidence follows the extension: min(1, F0 x colour) x weight.
TEST(LayeredBsdf, ReflectionUsesTheSpecularColour) {
  BsdfParameters p{.base_color = Rgb(0), .roughness = 0, .specular = .5f};
  p.specular_color = Rgb(2, 1, 40);
  const SurfaceBsdf bsdf(p, kUp);
  const BsdfSample s = bsdf.sample(0, Vec2f(.5f, 0));
  ASSERT_TRUE(s.valid && s.delta);
  const Rgb albedo = bsdf.albedo();
  EXPECT_NEAR(albedo.x, .5f * .08f, 1e-5f);
  EXPECT_NEAR(albedo.y, .5f * .04f, 1e-5f);
  EXPECT_NEAR(albedo.z, .5f, 1e-5f);
}

TEST(LayeredBsdf, ASmoothCoatMirrorsAboutItsOwnNormal) {
  Material m = white("", 0, 1);
  m.layers.clearcoat = 1;
  m.layers.clearcoat_normal = direction(std::cos(.2f), 0);
  const Vec3f wo = direction(std::cos(.5f), kPi);
  const SurfaceBsdf bsdf = m.at(wo);
  int found = 0;
  for (int i = 0; i < 100; ++i) {
    const BsdfSample s = bsdf.sample((float(i) + .5f) / 100, Vec2f(.3f, .6f));
    if (!s.valid || !s.delta) continue;
    ++found;
    // wo is 0.5 to one side of the vertical, and the normal 0.2 to the other, so the reflection is
    // at 0.9.
    EXPECT_NEAR((s.wi - direction(std::cos(.9f), 0)).length(), 0, 1e-5f);
  }
  EXPECT_GT(found, 0);
}

}  // namespace
}  // namespace emberline
