// Case 2: the limits of roughness. A sky whose radiance grows with height shows the shape of a
// white metal's lobe, which a uniform furnace cannot show.
#include <cstring>

#include "closed_form.h"
#include "lobe_albedo.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr double kBase = 1, kSlope = 0.5;  // radiance kBase + kSlope y

// Linear interpolation of rows h apart misses a cosine by at most h^2 / 8.
constexpr int kRows = 256;
const double kRowError = kSlope * square(kPiD / kRows) / 8;

std::shared_ptr<const Image> gradient_sky() {
  auto image = std::make_shared<Image>();
  image->width = 4;
  image->height = kRows;
  image->channels = 3;
  image->type = TexelType::kFloat;
  std::vector<float> texels;
  for (int y = 0; y < kRows; ++y)
    texels.insert(texels.end(), 12, float(kBase + kSlope * std::cos(kPiD * (y + .5) / kRows)));
  image->texels.resize(texels.size() * sizeof(float));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  return image;
}

void expect_reflection(const CaseName& name, float roughness, double mu, double exact,
                       double tolerance) {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 256;
  s.max_depth = 2;
  s.seed = seed_of(name);
  SceneBuilderForTests b;
  b.add_floor(100, 0, b.add_material(metal(Rgb(1.0f), roughness)));
  b.set_environment(gradient_sky());
  const double sine = std::sqrt((1 - mu) * (1 + mu));
  const CameraDescription view = orthographic({10 * sine, 10 * mu, 0}, {0, 0, 0}, 0.01);
  expect_case(name, compared(render(*b.build(), view, s), exact, tolerance), replay(s));
}

// Single scattering gives kBase E + kSlope H, where H is the lobe's integral under radiance wi.z.
// The remaining energy, 1 - E(mu), leaves with the pdf (1 - E(mu')) mu' / pi (1 - Eavg) (Kulla &
// Conty 2017).
double exact_reflection(double mu, double alpha) {
  static const GaussLegendre<48> rule;
  const LobeIntegrals at = lobe_integrals(mu, alpha);
  double lost = 0, lost_height = 0;
  for (size_t i = 0; i < 48; ++i) {
    const double t = rule.x[i], m = t * t * t;
    const double weight =
        rule.w[i] * 2 * m * 3 * t * t * (1 - lobe_integrals(m, alpha, 1.5, 8).white);
    lost += weight;
    lost_height += weight * m;
  }
  return kBase * at.white + kSlope * at.height +
         (1 - at.white) * (kBase + kSlope * lost_height / lost);
}

// Compares every roughness with quadrature. The tolerance of 2e-3 of the radiance covers the albedo
// tables, as in the furnace.
TEST(NarrowLobe, SkyInARoughMetal) {
  for (const double alpha : {.01, .1, .25, .5, 1.0})
    for (const double mu : {1.0, .5, .1, .01})
      expect_reflection(
          {"2", "sky in metal, alpha " + format_value(alpha) + ", mu " + format_value(mu)},
          float(std::sqrt(alpha)), mu, exact_reflection(mu, alpha), 2e-3 * (kBase + kSlope));
}

// Roughness goes to 0. Below kMirrorAlpha the lobe is a mirror. Just above kMirrorAlpha it spreads
// by alpha^2 ln(1 / alpha) / mu, which is below 1e-4 here. The catalogue of hard cases allows 1e-3.
TEST(NarrowLobe, MeetsTheMirror) {
  const float narrowest = std::nextafter(std::sqrt(kMirrorAlpha), 1.0f);
  for (const double mu : {1.0, .5, .1})
    for (const float roughness : {0.0f, float(std::sqrt(1e-7)), 0.0316f, narrowest}) {
      const bool mirror = roughness < narrowest;
      // The tolerance of 1e-6 covers float arithmetic.
      expect_reflection({"2", "mirror's limit, alpha " + format_value(double(square(roughness))) +
                                  (mirror ? " (mirror)" : "") + ", mu " + format_value(mu)},
                        roughness, mu, kBase + kSlope * mu, mirror ? kRowError + 1e-6 : 1e-3);
    }
}

}  // namespace
}  // namespace emberline
