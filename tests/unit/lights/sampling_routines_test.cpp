// Tests sampling routines that other tests reach only as parts of larger ones, each with the
// chi-square harness: single lobes, sample weights, the whole light sampler, discrete choices,
// texels, and the hashed extra numbers. README.md lists every routine with its test. The
// false-alarm rate of each test is 1e-6.
#include <gtest/gtest.h>

#include <cstring>

#include "renderer/core/warps.h"
#include "renderer/lights/fixed_cdf.h"
#include "renderer/lights/light_bvh.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/texture.h"
#include "samplers/pixel_samples.h"
#include "support/directions.h"
#include "support/light_scenes.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace)

// ---- lobes -------------------------------------------------------------------------------------

TEST(SamplingRoutines, GgxOverTheHemisphere) {
  const std::pair<float, float> cases[] = {{.1f, 1.0f}, {.1f, .1f},  {.25f, .5f},
                                           {.5f, 1.0f}, {.5f, .01f}, {1.0f, .3f}};
  for (const auto& [alpha, mu] : cases) {
    const GgxReflection lobe(alpha, direction(mu, 1));
    EXPECT_TRUE(chi_square_directions(
        [&](TestRandom& random) -> std::optional<Vec3f> {
          const Vec3f wi = lobe.sample(random.vec2());
          if (!(wi.z > 0)) return std::nullopt;
          return wi;
        },
        [&](const Vec3f& wi) { return wi.z > 0 ? double(lobe.evaluate(wi).pdf) : 0; },
        {.samples = 200'000, .seed = 11, .tests = int(std::size(cases))}, 0))
        << "alpha " << alpha << " mu " << mu;
  }
}

// In the hemisphere, a narrow lobe would fall into one bin. So the bins are in the slopes of the
// microfacet normal h, in units of alpha: dw_h = h.z^3 dslopes, dw_i = 4 (wo.h) dw_h.
TEST(SamplingRoutines, NarrowGgxInSlopes) {
  const std::pair<float, float> cases[] = {{1e-3f, 1.0f}, {1e-3f, .2f}, {.01f, .9f}, {.01f, .1f}};
  for (const auto& [alpha, mu] : cases) {
    const Vec3f wo = direction(mu, 1);
    const GgxReflection lobe(alpha, wo);
    const double scale = double(alpha);
    EXPECT_TRUE(chi_square_test(
        [&](TestRandom& random) -> std::optional<ChiSquarePoint> {
          const Vec3f wi = lobe.sample(random.vec2());
          const Vec3d h = Vec3d(wo) + Vec3d(wi);
          const ChiSquarePoint p{h.x / h.z / scale, h.y / h.z / scale, 1};
          if (!(wi.z > 0) || std::abs(p.x) > 4 || std::abs(p.y) > 4) return std::nullopt;
          return p;
        },
        [&](double x, double y) {
          Vec3d h(x * scale, y * scale, 1);
          h /= std::sqrt(dot(h, h));
          const double cos_d = dot(Vec3d(wo), h);
          const Vec3d wi = h * (2 * cos_d) - Vec3d(wo);
          if (!(cos_d > 0) || !(wi.z > 0)) return 0.0;
          // The half vector of two float directions has a relative error of 6e-8 / alpha in its
          // slopes.
          return double(lobe.evaluate(Vec3f(wi)).pdf) * 4 * cos_d * square(h.z) * h.z *
                 square(scale);
        },
        {-4, 4, -4, 4}, {.samples = 200'000, .seed = 12, .tests = int(std::size(cases))}))
        << "alpha " << alpha << " mu " << mu;
  }
}

BsdfParameters material(float metallic, float alpha, float transmission, bool thin, bool inside) {
  return {.base_color = Rgb(.9f),
          .metallic = metallic,
          .roughness = std::sqrt(alpha),
          .transmission = transmission,
          .thin_walled = thin,
          .inside = inside};
}

const BsdfParameters kMaterials[] = {
    material(0, .3f, 0, true, false),    material(1, .2f, 0, true, false),
    material(.5f, 1, 0, true, false),    material(0, .3f, 1, true, false),
    material(0, .3f, 1, false, false),   material(0, .3f, 1, false, true),
    material(.3f, .4f, .5f, true, false)};

BsdfSample draw(const SurfaceBsdf& bsdf, TestRandom& random) {
  const float lobe = random.next();
  return bsdf.sample(lobe, random.vec2());
}

// A bare Lambertian surface has one lobe and no lobe selection.
TEST(SamplingRoutines, Lambert) {
  BsdfParameters p = material(0, 1, 0, true, false);
  p.specular = 0;
  const SurfaceBsdf bsdf(p, direction(.3f, 2));
  EXPECT_TRUE(chi_square_directions(
      [&](TestRandom& random) { return std::optional(draw(bsdf, random).wi); },
      [&](const Vec3f& wi) { return std::max(0.0, double(wi.z)) / kPiD; }, {.seed = 13}));
}

// The histogram of weighted samples equals the value of the BSDF, as paths require.
TEST(SamplingRoutines, WeightsGiveTheValue) {
  for (size_t i = 0; i < std::size(kMaterials); ++i) {
    const SurfaceBsdf bsdf(kMaterials[i], direction(.6f, .7f));
    EXPECT_TRUE(chi_square_test(
        [&](TestRandom& random) -> std::optional<ChiSquarePoint> {
          const BsdfSample s = draw(bsdf, random);
          if (!s.valid) return std::nullopt;
          double phi = std::atan2(double(s.wi.y), double(s.wi.x));
          if (phi < 0) phi += 2 * kPiD;
          return ChiSquarePoint{double(s.wi.z), phi, double(s.weight.x)};
        },
        [&](double z, double phi) { return double(bsdf.eval(direction(float(z), float(phi))).x); },
        {-1, 1, 0, 2 * kPiD},
        {.bins_x = 32, .samples = 200'000, .seed = 14, .tests = int(std::size(kMaterials))}))
        << "material " << i;
  }
}

// ---- lights ------------------------------------------------------------------------------------

// Tests everything together: the choice between sky and triangles, the choice of a triangle, by
// power and by tree, and the point on it. The directions of the samples are compared with the sum
// of all pdfs.
TEST(SamplingRoutines, WholeLightSampler) {
  const Vec3f kPoint(.1f, -.3f, .2f);
  Triangles list;
  for (uint64_t i = 0; i < 16; ++i) {
    // The query sees the triangle at a fair size and not edge-on. A sliver would fall between the
    // points at which the harness integrates.
    TestRandom random(15, i);
    const Vec3f away = square_to_sphere(random.vec2());
    const Vec3f u = normalize(cross(away, Vec3f(.3f, .1f, .9f))), v = cross(away, u);
    const Vec3f at = kPoint + away * (1 + random.next());
    const auto aside = [&](float turn) {
      const float phi = 2 * kPi * (turn + .2f * random.next());
      return (u * std::cos(phi) + v * std::sin(phi) + away * (.6f * random.next() - .3f)) *
             (.3f + .5f * random.next());
    };
    // Every second triangle faces away.
    const Vec3f p0 = at + aside(0), p1 = at + aside(i % 2 ? .33f : .67f);
    list.push_back(
        triangle(p0, p1, at + aside(i % 2 ? .67f : .33f), random.next() + .1f, i % 3 == 0));
  }
  const auto sky = std::make_shared<EnvironmentLight>(Rgb(.2f));
  for (const uint32_t threshold : {1u, 1000u}) {
    const LightSampler lights = make_light_sampler(list, {}, sky, threshold);
    const LightQuery query{kPoint, normalize(Vec3f(.2f, 1, .3f)), false};
    EXPECT_TRUE(chi_square_directions(
        [&](TestRandom& random) -> std::optional<Vec3f> {
          const float pick = random.next();
          const LightSample s = test::sample_one(lights, query, pick, random.vec2());
          if (s.kind == LightKind::kNone) return std::nullopt;
          return s.direction;
        },
        [&](const Vec3f& w) {
          double sum = double(test::pdf_environment(lights, query, w));
          for (uint32_t i = 0; i < list.size(); ++i) {
            const EmissiveTriangle& t = list[i];
            const Vec3d e1 = Vec3d(t.p1) - Vec3d(t.p0), e2 = Vec3d(t.p2) - Vec3d(t.p0);
            const Vec3d d(w), s = Vec3d(query.point) - Vec3d(t.p0), p = cross(d, e2);
            const double det = dot(e1, p), b1 = dot(s, p) / det, b2 = dot(d, cross(s, e1)) / det;
            const double distance = dot(e2, cross(s, e1)) / det;
            if (b1 >= 0 && b2 >= 0 && b1 + b2 <= 1 && distance > 0)
              sum += double(lights.pdf_triangle(query, i, float(distance)));
          }
          return sum;
        },
        {.bins_x = 24, .samples = 200'000, .seed = 16, .tests = 2}))
        << "threshold " << threshold;
  }
}

TEST(SamplingRoutines, LightBvhPicks) {
  std::vector<EmitterBounds> bounds;
  constexpr int kCount = 60;
  for (int i = 0; i < kCount; ++i) {
    TestRandom random(17, uint64_t(i));
    EmitterBounds b;
    b.lower = Vec3f(random.next() * 4 - 2, random.next() * 4 - 2, random.next() * 4 - 2);
    b.upper = b.lower + Vec3f(random.next(), random.next(), random.next()) * .5f;
    b.axis = square_to_sphere(random.vec2());
    b.cos_theta_o = random.next();
    b.intensity = double(random.next() + .01f);
    bounds.push_back(b);
  }
  const LightBvh bvh{std::span<const EmitterBounds>(bounds)};
  const LightQuery query{Vec3f(.3f, .1f, -.2f), Vec3f(0, 1, 0), false};
  EXPECT_TRUE(chi_square_test(
      [&](TestRandom& random) -> std::optional<ChiSquarePoint> {
        const LightBvh::Pick pick = bvh.pick(query, random.next_double());
        if (!(pick.probability > 0)) return std::nullopt;
        return ChiSquarePoint{pick.emitter + .5, random.next_double(), 1};
      },
      [&](double x, double) { return double(bvh.probability(query, uint32_t(x))); },
      {0, kCount, 0, 1}, {.bins_x = kCount, .bins_y = 1, .seed = 18}));
}

// An entry and the position within it make a point of the piecewise constant pdf.
TEST(SamplingRoutines, FixedCdf) {
  std::vector<double> weights;
  for (uint64_t i = 0; i < 200; ++i) {
    TestRandom random(19, i);
    weights.push_back(random.next() < .3f ? 0.0 : square(random.next_double()));
  }
  double total = 0;
  for (const double w : weights) total += w;
  std::vector<uint32_t> sums(weights.size() + 1), guide(guide_words(weights.size()));
  build_fixed_cdf(weights, sums.data(), guide.data());
  EXPECT_TRUE(chi_square_test(
      [&](TestRandom& random) -> std::optional<ChiSquarePoint> {
        const CdfChoice c =
            choose_entry(sums.data(), guide.data(), guide_bits(weights.size()), random.next());
        return ChiSquarePoint{double(c.index) + double(c.remainder), random.next_double(), 1};
      },
      [&](double x, double) { return weights[std::min(size_t(x), weights.size() - 1)] / total; },
      {0, 200, 0, 1}, {.bins_x = 400, .bins_y = 1, .seed = 20}));
}

// ---- texels and numbers ------------------------------------------------------------------------

// A lookup chooses one of the four texels around a point, with its bilinear weight as the
// probability.
TEST(SamplingRoutines, StochasticTexel) {
  auto image = std::make_shared<Image>();
  image->width = image->height = 2;
  image->channels = 1;
  const uint8_t texels[4] = {0, 60, 120, 180};
  image->texels.resize(4);
  std::memcpy(image->texels.data(), texels, 4);
  const Texture texture(image, TextureRef{.image = 0}, false);
  const double fx = .37, fy = .81;
  const Vec2f uv(float((.5 + fx) / 2), float((.5 + fy) / 2));
  EXPECT_TRUE(chi_square_test(
      [&](TestRandom& random) -> std::optional<ChiSquarePoint> {
        const int index = int(std::lround(double(texture.lookup(uv, random.next()).x) * 255 / 60));
        return ChiSquarePoint{index % 2 + .5, index / 2 + .5, 1};
      },
      [&](double x, double y) { return (x < 1 ? 1 - fx : fx) * (y < 1 ? 1 - fy : fy); },
      {0, 2, 0, 2}, {.bins_x = 2, .bins_y = 2, .seed = 21}));
}

// Tests pairs of neighbours among the hashed extra numbers, over samples, slots and pixels.
TEST(SamplingRoutines, ExtraNumbersInPairs) {
  const auto sampler = create_sampler("sobol", {});
  PixelSamples samples(*sampler);
  uint32_t next = 0;
  EXPECT_TRUE(chi_square_test(
      [&](TestRandom&) -> std::optional<ChiSquarePoint> {
        const uint32_t i = next++;
        const int sample = int(i & 15u);
        if (sample == 0) samples.start_batch({(i >> 4) % 64, (i >> 10), 1}, 0, kSampleLanes);
        samples.start_sample(sample);
        samples.start_slot(1 + i % 3);
        const double x = double(samples.extra());
        return ChiSquarePoint{x, double(samples.extra()), 1};
      },
      [](double, double) { return 1.0; }));
}

}  // namespace
}  // namespace emberline
