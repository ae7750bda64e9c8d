// Tests direct light against closed-form irradiance: the published rectangle, and the two sides of
// a light (emitter_shapes_test.cpp tests other shapes). The receiver is a Lambertian floor of
// albedo 1, seen from straight above, so its radiance is E / pi.
#include "receiver.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// Renders a spot of the floor around `at`. The spot is 1e-4 in half size, and E is constant within
// it.
RenderedImage irradiance_at(SceneBuilderForTests& b, const Vec3d& at, const RenderSettings& s,
                            double camera_height = 0.2) {
  b.add_floor(1000, 0, b.add_material(lambert(Rgb(1.0f))));
  const auto scene = b.build();
  return render(*scene, orthographic(at + Vec3d(0, camera_height, 0), at, 1e-4), s);
}

double lambert_polygon(const std::vector<Vec3d>& corners, const Vec3d& at) {
  // Lambert 1760: E is L / 2 times a sum over the polygon's edges. Each edge contributes the angle
  // that it subtends at the point, times n . m, where m is the unit normal of the plane through the
  // edge and the point. The whole polygon must be above the horizon.
  double sum = 0;
  for (size_t k = 0; k < corners.size(); ++k) {
    const Vec3d a = (corners[k] - at).normalized();
    const Vec3d b = (corners[(k + 1) % corners.size()] - at).normalized();
    const Vec3d c = a.cross(b);
    sum += std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * c.normalized().y;
  }
  return std::abs(sum) / 2;
}

// Case 6: a rectangular lamp, parallel to the floor and off centre. The published value .683537
// checks the formula.
TEST(AreaLight, Rectangle) {
  const double x0 = -.5, x1 = .9, z0 = -.3, z1 = .7, h = 1.2;
  const std::vector<Vec3d> corners = {{x0, h, z0}, {x1, h, z0}, {x1, h, z1}, {x0, h, z1}};
  const double exact = lambert_polygon(corners, Vec3d(0.0));
  EXPECT_NEAR(exact, 0.683537, 1e-6);
  SceneBuilderForTests b;
  b.add_quad({-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f},
             b.add_material(emitter(Rgb(1.0f))));
  const RenderSettings s = direct_light_settings();
  expect_exact(irradiance_at(b, Vec3d(0.0), s), exact / kPiD, 1e-5, s, {"6", "rectangle"});
}

// BSDF sampling alone estimates the same irradiance without the light sampler.
TEST(AreaLight, RectangleByBsdfSampling) {
  SceneBuilderForTests b;
  b.add_quad({-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f},
             b.add_material(emitter(Rgb(1.0f))));
  RenderSettings s = direct_light_settings();
  s.light_samples = 0;
  s.spp = 4096;
  expect_exact(irradiance_at(b, Vec3d(0.0), s), 0.683537 / kPiD, 1e-5, s, {"6", "rectangle, BSDF"});
}

// A one-sided emitter gives light only on its front, a two-sided emitter on both sides.
TEST(AreaLight, Sides) {
  for (const bool two_sided : {false, true}) {
    SceneBuilderForTests b;
    MaterialDescription m = emitter(Rgb(1.0f));
    m.double_sided = two_sided;
    const int material = b.add_material(m);
    b.add_floor(.5f, 1.0f, material, /*up=*/true);  // faces away from the receiver
    const RenderSettings s = direct_light_settings();
    const std::vector<Vec3d> corners = {{-.5, 1, -.5}, {.5, 1, -.5}, {.5, 1, .5}, {-.5, 1, .5}};
    const double exact = two_sided ? lambert_polygon(corners, Vec3d(0.0)) : 0.0;
    expect_exact(irradiance_at(b, Vec3d(0.0), s), exact / kPiD, 1e-5, s,
                 {"20", two_sided ? "two-sided" : "from behind"});
  }
}

}  // namespace
}  // namespace emberline
