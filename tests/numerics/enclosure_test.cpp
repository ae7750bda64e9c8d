// Multiple scattering in closed cavities, where the exact value is a geometric series.
#include "closed_form.h"

#include "renderer/core/moments.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// After k scattering events, a closed sphere that emits Le and reflects rho has the radiance Le (1
// - rho^(k+1)) / (1 - rho) everywhere. Its tessellation does not matter.
RenderedImage inside_sphere(float emission, float rho, int depth, const RenderSettings& base) {
  SceneBuilderForTests b;
  MaterialDescription m = lambert(Rgb(rho));
  m.emission = Rgb(emission);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(1.0f, 8, b.add_material(m), /*inward=*/true)));
  const auto scene = b.build();
  RenderSettings s = base;
  s.max_depth = depth;
  const CameraDescription view = perspective({0, 0, 0}, {0.2, 0.1, -1}, 90);
  ByGuiding::expect_guide(*scene, view, s);
  return render(*scene, view, s);
}

RenderSettings enclosure_settings() {
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = 64;
  return s;
}

class Enclosure : public ByGuiding {};

// The tolerance of 1e-5 covers float arithmetic.
TEST_P(Enclosure, DepthSeries) {
  RenderSettings s = with_guiding(enclosure_settings());
  for (const float reflectance : {.2f, .5f, .9f})
    for (const int depth : {0, 1, 2, 5, 20}) {
      if (depth < 2 && s.guiding == Guiding::kOn) continue;  // no indirect light
      const double rho = double(reflectance);
      const double exact = (1 - std::pow(rho, depth + 1)) / (1 - rho);
      const CaseName sphere = name(
          "3", "closed sphere, rho " + format_value(rho) + ", to depth " + std::to_string(depth));
      s.seed = seed_of(sphere);
      expect_exact(inside_sphere(1.0f, reflectance, depth, s), exact, 1e-5, s, sphere);
    }
}

// Case 3: with rho = .99, most of the light comes from paths that have survived Russian roulette.
TEST_P(Enclosure, RouletteCarriesLongPaths) {
  RenderSettings s = with_guiding(enclosure_settings());
  s.width = s.height = 8;
  s.spp = long_or_short(256u, 64u);
  for (const float rho : {.5f, .9f, .99f}) {
    const CaseName sphere =
        name("3", "closed sphere, rho " + format_value(double(rho)) + ", to the end");
    s.seed = seed_of(sphere);
    expect_exact(inside_sphere(1 - rho, rho, 100000, s), 1.0, 1e-5, s, sphere);
  }
}

// Case 4: a cap of half-angle a is cut away from the sphere. From every point of a perfect sphere,
// the black outside has the form factor f = (1 - cos a) / 2, so L = Le / (1 - rho (1 - f)). The
// faces of 48 rings lie up to 1.1e-3 of the radius inside the sphere, so the relative error of f is
// at most 2.2e-3. That of L is rho f / (1 - rho (1 - f)) times as large, at most 1e-3 below.
TEST_P(Enclosure, SphereWithOpening) {
  const int rings = 48;
  for (const auto& [rho, open_rings] :
       {std::pair{.8, 16}, std::pair{.8, 24}, std::pair{.95, 8}, std::pair{.3, 40}}) {
    const double a = kPiD * open_rings / rings, f = (1 - std::cos(a)) / 2;
    SceneBuilderForTests b;
    MaterialDescription m = lambert(Rgb(float(rho)));
    m.emission = Rgb(1.0f);
    MeshDescription sphere =
        SceneBuilderForTests::sphere(1.0f, rings, b.add_material(m), /*inward=*/true);
    std::erase_if(sphere.triangles, [&](const std::array<uint32_t, 3>& t) {
      const uint32_t open_end = uint32_t(open_rings) * 2 * uint32_t(rings);
      return std::min({t[0], t[1], t[2]}) < open_end;
    });
    b.place(b.add_mesh(std::move(sphere)));
    b.set_environment(Rgb(0.0f));
    const auto scene = b.build();
    const double exact = 1 / (1 - rho * (1 - f));
    const CaseName opening = name(
        "4", "opening of " + format_value(a * 180 / kPiD) + " degrees, rho " + format_value(rho));
    RenderSettings s = with_guiding(enclosure_settings());
    s.max_depth = 1000;
    s.seed = seed_of(opening);
    if (open_rings == 16) {
      EXPECT_NEAR(exact, 2.5, 1e-12);  // from the catalogue
    }
    // The camera sees the bottom of the sphere, along the opening's axis.
    expect_exact(render(*scene, perspective({0, -.8, 0}, {0, -1, 0.001}, 60), s), exact,
                 rho * f * exact * 2.2e-3, s, opening);
  }
}

// Case 5: a point light at the centre of an integrating sphere gives L = rho Phi / (4 pi^2 R^2 (1 -
// rho)).
TEST_P(Enclosure, IntegratingSphere) {
  const double rho = .5, radius = 2, intensity = 3;  // Phi = 4 pi I
  SceneBuilderForTests b;
  b.place(b.add_mesh(SceneBuilderForTests::sphere(float(radius), 48,
                                                  b.add_material(lambert(Rgb(float(rho)))), true)));
  b.add_point_light({0, 0, 0}, Rgb(float(intensity)));
  const auto scene = b.build();
  RenderSettings s = with_guiding(enclosure_settings());
  s.max_depth = 1000;
  const double exact = rho * 4 * kPiD * intensity / (4 * square(kPiD * radius)) / (1 - rho);
  // The faces of a sphere with 48 rings lie up to 1e-3 of the radius inside it, closer to the
  // light.
  expect_exact(render(*scene, perspective({0.5, 0, 0}, {0, 0.3, -1}, 90), s), exact, 4e-3, s,
               name("5", "integrating sphere"));
}

// Case 5 off centre: all points of a sphere have equal form factors to one another. So the light
// after the wall's first scattering is uniform, rho^2 Phi / (4 pi^2 R^2 (1 - rho)), wherever the
// lamp is. That light is the full picture minus the direct one, rendered with the same samples.
TEST_P(Enclosure, IntegratingSphereOffCentre) {
  const double rho = .7, radius = 2, intensity = 3;
  for (const double off : {.5, 1.0}) {
    SceneBuilderForTests b;
    b.place(b.add_mesh(SceneBuilderForTests::sphere(
        float(radius), 48, b.add_material(lambert(Rgb(float(rho)))), true)));
    b.add_point_light({off, 0, 0}, Rgb(float(intensity)));
    const auto scene = b.build();
    const CaseName lamp = name("5", "light " + format_value(off) + " off the centre, indirect");
    RenderSettings s = with_guiding(enclosure_settings());
    s.spp = 256;
    s.seed = seed_of(lamp);
    const CameraDescription view = perspective({0.5, 0, 0}, {0, 0.3, -1}, 90);
    s.max_depth = 1;
    const RenderedImage direct = render(*scene, view, s);
    s.max_depth = 1000;
    const RenderedImage full = render(*scene, view, s);
    Moments indirect;
    for (int y = 0; y < s.height; ++y)
      for (int x = 0; x < s.width; ++x)
        indirect.add(double(full.rgb(x, y).x) - double(direct.rgb(x, y).x));
    const double flux = 4 * kPiD * intensity;
    const double exact = rho * rho * flux / (4 * square(kPiD * radius)) / (1 - rho);
    // The faces lie up to 1.1e-3 of the radius inside the sphere, so areas are smaller by 2.2e-3
    // and the form factors of each bounce are larger by as much. This error counts twice, for the
    // light and for the last bounce.
    expect_case(lamp, {exact, indirect.mean(), indirect.standard_error(), 4.4e-3 * exact},
                replay(s));
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, Enclosure, kWithAndWithoutGuiding, guiding_name);

}  // namespace
}  // namespace emberline
