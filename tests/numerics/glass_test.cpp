// Glass: slabs with exact reflectance and transmittance, and solids that are invisible in a
// furnace.

#include "closed_form.h"
#include "support/glass_scenes.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// Adds a slab of thickness d and width 2000, whose top is at y = 0. It consists of two quads with
// outward normals.
void add_slab(SceneBuilderForTests& b, const MaterialDescription& m, float d) {
  const int material = b.add_material(m);
  b.add_floor(1000, 0, material, /*up=*/true);
  b.add_floor(1000, -d, material, /*up=*/false);
}

RenderSettings glass_settings() {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 1024;
  s.max_depth = 200;
  return s;
}

CameraDescription from_angle(double theta, bool above) {
  const Vec3d direction(std::sin(theta), above ? std::cos(theta) : -std::cos(theta), 0.3e-3);
  // The target lies off the quads' diagonals.
  const Vec3d at(7.3, above ? 0.0 : -0.1, 3.1);
  return orthographic(at + direction * 5.0, at, 1e-3);
}

// Case 13: a slab reflects 2R / (1 + R), where R is the reflectance of one face, and transmits the
// rest.
TEST(GlassSlab, ReflectsAndTransmitsExactly) {
  const double eta = 1.5;
  const double published[] = {.076923, .079216, .143891, .390510};
  const double angles[] = {0, .5, 1, 1.3};
  for (int i = 0; i < 4; ++i) {
    const double r = fresnel(angles[i], eta), exact = 2 * r / (1 + r);
    EXPECT_NEAR(exact, published[i], 2e-6);
    SceneBuilderForTests b;
    add_slab(b, glass(float(eta), 0, true), 0.1f);
    b.set_environment(upper_half());
    const auto scene = b.build();
    const RenderSettings s = glass_settings();
    expect_exact(render(*scene, from_angle(angles[i], true), s), exact, 1e-5, s,
                 {"13", "slab reflectance at " + std::to_string(angles[i])});
    expect_exact(render(*scene, from_angle(angles[i], false), s), 1 - exact, 1e-5, s,
                 {"13", "slab transmittance at " + std::to_string(angles[i])});
  }
}

// The same slab with absorption, which leaves a = exp(-sigma d / cos t) of the light on each
// crossing.
TEST(GlassSlab, Absorbs) {
  const double eta = 1.5, theta = .5, d = .1, half_distance = .15;
  MaterialDescription m = glass(float(eta), 0, true);
  m.attenuation_color = Rgb(0.5f);
  m.attenuation_distance = float(half_distance);
  SceneBuilderForTests b;
  add_slab(b, m, float(d));
  b.set_environment(upper_half());
  const auto scene = b.build();
  const double r = fresnel(theta, eta);
  const double cos_t = std::sqrt(1 - square(std::sin(theta) / eta));
  const double a = std::exp(-std::log(2.0) / half_distance * d / cos_t);
  const RenderSettings s = glass_settings();
  expect_exact(render(*scene, from_angle(theta, true), s),
               r + square(1 - r) * r * a * a / (1 - r * r * a * a), 1e-5, s,
               {"13", "absorbing, reflected"});
  expect_exact(render(*scene, from_angle(theta, false), s), square(1 - r) * a / (1 - r * r * a * a),
               1e-5, s, {"13", "absorbing, passed"});
}

// A solid of index 1 is invisible, and so is a thin wall of index 1.
TEST(Glass, IndexOneIsInvisible) {
  for (const bool solid : {false, true}) {
    SceneBuilderForTests b;
    add_slab(b, glass(1.0f, 0, solid), 0.1f);
    b.set_environment(upper_half());
    const auto scene = b.build();
    const RenderSettings s = glass_settings();
    expect_exact(render(*scene, from_angle(.7, true), s), 0.0, 0, s, {"14", "index 1 from above"});
    expect_exact(render(*scene, from_angle(.7, false), s), 1.0, 1e-6, s,
                 {"14", "index 1 from below"});
  }
}

// Case 14: a clear ball in a furnace, smooth or rough, disappears.
TEST(Glass, BallInAFurnace) {
  for (const float roughness : {0.0f, 0.3f, 0.7f}) {
    SceneBuilderForTests b;
    b.place(b.add_mesh(SceneBuilderForTests::sphere(
        1.0f, 48, b.add_material(glass(1.5f, roughness, true)), false, false)));
    b.set_environment(Rgb(1.0f));
    const auto scene = b.build();
    RenderSettings s = glass_settings();
    s.width = s.height = 16;
    s.spp = 256;
    s.max_depth = 1000;
    // The tolerance for a rough ball is 4e-3. The compensation is exact for one interface, but
    // inside the ball the table's interpolation error adds up over several bounces.
    expect_exact(render(*scene, perspective({0, 0, 4}, {0, 0, 0}, 25), s), 1.0,
                 roughness > 0 ? 4e-3 : 1e-5, s,
                 {"14", "ball of roughness " + std::to_string(roughness)});
  }
}

// Light sampling and BSDF sampling agree through a rough thin wall.
TEST(Glass, ThinRoughWallWithAndWithoutLightSampling) {
  SceneBuilderForTests b;
  b.add_floor(5, 0, b.add_material(glass(1.5f, 0.6f, false)));
  b.add_quad({-.6f, -1.2f, .7f}, {-.6f, -1.2f, -.7f}, {.9f, -1.2f, -.7f}, {.9f, -1.2f, .7f},
             b.add_material([] {
               MaterialDescription m = emitter(Rgb(4.0f));
               m.double_sided = true;
               return m;
             }()));
  const auto scene = b.build();
  RenderSettings s = glass_settings();
  s.spp = 4096;
  const CameraDescription view = orthographic({.3, 1, .2}, {.2, 0, .1}, 1e-3);
  const RenderedImage both = render(*scene, view, s);
  s.light_samples = 0;
  s.seed = 99;
  const RenderedImage bsdf = render(*scene, view, s);
  EXPECT_GT(both.mean, 0.1);
  EXPECT_NEAR(both.mean, bsdf.mean, 5 * std::hypot(both.standard_error, bsdf.standard_error));
}

}  // namespace
}  // namespace emberline
