// Closed cavities: multiple scattering with a geometric series as its exact value.
#include "closed_form.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// A closed sphere that emits Le and reflects rho is uniformly Le (1 - rho^(k+1)) / (1 - rho) bright
// after k scattering events, whatever its tessellation.
RenderedImage inside_sphere(float emission, float rho, int depth, const RenderSettings& base) {
  SceneBuilderForTests b;
  MaterialDescription m = lambert(Rgb(rho));
  m.emission = Rgb(emission);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(1.0f, 8, b.add_material(m), /*inward=*/true)));
  const auto scene = b.build();
  RenderSettings s = base;
  s.max_depth = depth;
  return render(*scene, perspective({0, 0, 0}, {0.2, 0.1, -1}, 90), s);
}

RenderSettings enclosure_settings() {
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = 64;
  return s;
}

TEST(Enclosure, DepthSeries) {
  const RenderSettings s = enclosure_settings();
  for (const int depth : {0, 1, 2, 5}) {
    const double rho = 0.5;
    const double exact = (1 - std::pow(rho, depth + 1)) / (1 - rho);
    expect_exact(inside_sphere(1.0f, 0.5f, depth, s), exact, 1e-5, s,
                 {"3", "closed sphere to depth " + std::to_string(depth)});
  }
}

// Case 3: rho = .99 leaves most of the light to Russian roulette.
TEST(Enclosure, RouletteCarriesLongPaths) {
  RenderSettings s = enclosure_settings();
  s.width = s.height = 8;
  expect_exact(inside_sphere(0.01f, 0.99f, 100000, s), 1.0, 1e-5, s, {"3", "rho .99"});
}

// Case 4: the same with a cap cut away, half-angle a: the cavity sees the black outside with form
// factor f = (1 - cos a) / 2, so L = Le / (1 - rho (1 - f)). The sphere's own chord rule makes f
// the same from every point, for a perfect sphere; 64 rings are within 2e-3 of one.
TEST(Enclosure, SphereWithOpening) {
  const double rho = .8;
  const int rings = 48, open_rings = rings / 3;  // 60 degrees
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
  const auto scene = b.build();
  RenderSettings s = enclosure_settings();
  s.max_depth = 1000;
  const double f = (1 - std::cos(kPiD / 3)) / 2;
  EXPECT_NEAR(1 / (1 - rho * (1 - f)), 2.5, 1e-12);
  // The bottom of the sphere, through the opening's axis.
  expect_exact(render(*scene, perspective({0, 0, 0}, {0, -1, 0.001}, 60), s), 2.5, 3e-3, s,
               {"4", "sphere with a 60 degree opening"});
}

// Case 5: a point light at the centre of an integrating sphere, L = rho Phi / (4 pi^2 R^2 (1 -
// rho)).
TEST(Enclosure, IntegratingSphere) {
  const double rho = .5, radius = 2, intensity = 3;  // Phi = 4 pi I
  SceneBuilderForTests b;
  b.place(b.add_mesh(SceneBuilderForTests::sphere(float(radius), 48,
                                                  b.add_material(lambert(Rgb(float(rho)))), true)));
  b.add_point_light({0, 0, 0}, Rgb(float(intensity)));
  const auto scene = b.build();
  RenderSettings s = enclosure_settings();
  s.max_depth = 1000;
  const double exact = rho * 4 * kPiD * intensity / (4 * square(kPiD * radius)) / (1 - rho);
  // Faces of a sphere with 48 rings lie up to 1e-3 inside it: closer to the light.
  expect_exact(render(*scene, perspective({0.5, 0, 0}, {0, 0.3, -1}, 90), s), exact, 4e-3, s,
               {"5", "integrating sphere"});
}

}  // namespace
}  // namespace emberline
