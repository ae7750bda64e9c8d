// Material layers in whole frames: a coat dims the emission below it (E42), and a prism refracts
// each wavelength by Snell's law (E43).
#include "lamp_over_floor.h"
#include "renderer/core/moments.h"
#include "renderer/shading/lobes/wavelength.h"
#include "support/glass_scenes.h"

namespace emberline {
namespace {

using namespace test;

// KHR_materials_clearcoat multiplies emission by 1 - clearcoat F, where F = .04 + .96 (1 - mu)^5.
TEST(Layers, CoatDimsALamp) {
  for (const float clearcoat : {.5f, 1.0f}) {
    SceneBuilderForTests b = white_floor();
    MaterialDescription lamp = emitter(Rgb(50.0f));
    lamp.clearcoat = clearcoat;
    add_lamp(b, lamp);
    const double exact = lamp_irradiance(
        [&](double mu) { return 1 - double(clearcoat) * (.04 + .96 * std::pow(1 - mu, 5)); });
    // The tolerance is 1e-4, since the lamp's corners are floats, and the midpoint rule errs by 1 /
    // 24 steps^2.
    expect_irradiance_at("E42", b, exact, 1e-4, "lamp under a coat of " + format_value(clearcoat));
  }
}

// A ray hits the first face of a prism at normal incidence, and the second at 30 degrees from
// inside. A distant screen emits beyond the point where light of `edge` nanometres arrives, so the
// picture sums up the shorter wavelengths. A `max_depth` of 2 cuts off reflections at either face.
struct Prism {
  static constexpr double kAngle = kPiD / 6, kScreen = 1000, kIor = 1.5, kDispersion = 2;

  static double ior(double nanometres) {
    // Cauchy's A + B / lambda^2 with the Abbe number 20 / dispersion and the index kIor at 587.56
    // nm.
    const double b = (kIor - 1) * kDispersion / 20 / (1 / square(486.13) - 1 / square(656.27));
    return kIor + b * (1 / square(nanometres) - 1 / square(587.56));
  }
  // Returns how far the refraction moves the ray's hit point on the screen. Without refraction at
  // the second face, the ray would hit the screen straight below its exit point.
  static double deflection(double nanometres) {
    return kScreen * std::tan(std::asin(ior(nanometres) * std::sin(kAngle)) - kAngle);
  }
  static double transmitted(double nanometres) {
    const double n = ior(nanometres);
    return (1 - fresnel(0, n)) * (1 - fresnel(kAngle, 1 / n));
  }
};

// Returns a midpoint sum over u. A unit test checks the integrals of the responses over u.
Rgb prism_exact(double edge) {
  double sum[3] = {0, 0, 0};
  constexpr int kSteps = 400'000;
  for (int i = 0; i < kSteps; ++i) {
    const SampledWavelength w = sample_wavelength((float(i) + .5f) / kSteps);
    if (double(w.nanometres) > edge) continue;
    for (int c = 0; c < 3; ++c) {
      sum[c] += double(w.weight[c]) * Prism::transmitted(double(w.nanometres)) / kSteps;
    }
  }
  return {float(sum[0]), float(sum[1]), float(sum[2])};
}

TEST(Layers, PrismBendsByTheWavelength) {
  for (const double edge : {450.0, 500.0, 550.0, 600.0, 1000.0}) {
    SceneBuilderForTests b;
    MaterialDescription m = glass(float(Prism::kIor), 0);
    m.dispersion = float(Prism::kDispersion);
    const int material = b.add_material(m);
    b.add_floor(2, 0, material);
    // The second face passes through (0, -3, 0). Its outer normal points 30 degrees from -Y towards
    // +X.
    const float run = 2, rise = run * float(std::tan(Prism::kAngle));
    b.add_quad({-run, -3 - rise, -1}, {run, -3 + rise, -1}, {run, -3 + rise, 1},
               {-run, -3 - rise, 1}, material);
    // Refracted light leaves towards -X.
    const auto x0 = float(-Prism::deflection(edge)), y = float(-3 - Prism::kScreen);
    b.add_quad({-900, y, 900}, {x0, y, 900}, {x0, y, -900}, {-900, y, -900},
               b.add_material(emitter(Rgb(1.0f))));
    const auto scene = b.build();
    RenderSettings s = direct_light_settings(long_or_short(4096u, 1024u));
    s.max_depth = 2;
    s.light_samples = 0;
    const std::string below = edge > 700 ? "all of it" : "below " + format_value(edge) + " nm";
    s.seed = seed_of({"E43", below});
    const RenderedImage image = render(*scene, orthographic({0, 1, 0}, {0, 0, 0}, 1e-4), s);
    EXPECT_EQ(image.counters.non_finite_samples, 0u);
    const Rgb exact = prism_exact(edge);
    for (int c = 0; c < 3; ++c) {
      const CaseName name{"E43", "prism, " + below + ", " + std::string(1, "RGB"[c])};
      Moments pixels;
      for (size_t i = size_t(c); i < image.values.size(); i += image.channels.size()) {
        pixels.add(double(image.values[i]));
      }
      // The tolerance is 2e-5. The view of 1e-4 moves the edge by 3e-6 of the spectrum's width, and
      // the rest covers float rounding.
      expect_case(name, {double(exact[c]), pixels.mean(), pixels.standard_error(), 2e-5},
                  replay(s));
    }
  }
}

}  // namespace
}  // namespace emberline
