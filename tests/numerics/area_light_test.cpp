// Direct light whose irradiance has a closed form. The receiver is a Lambert floor of albedo 1 seen
// from straight above, so that the picture is E / pi.
#include "closed_form.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings direct_settings() {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 1024;
  s.max_depth = 1;
  return s;
}

// The receiver and a camera that looks at a spot of 1e-4 around `at`, too small for E to change.
RenderedImage irradiance_at(SceneBuilderForTests& b, const Vec3d& at, const RenderSettings& s,
                            double camera_height = 0.2) {
  b.add_floor(1000, 0, b.add_material(lambert(Rgb(1.0f))));
  const auto scene = b.build();
  return render(*scene, orthographic(at + Vec3d(0, camera_height, 0), at, 1e-4), s);
}

double lambert_polygon(const std::vector<Vec3d>& corners, const Vec3d& at) {
  // Lambert 1760: E = L/2 sum over edges of the angle it subtends times n . (unit normal of the
  // plane through the edge and the point), all of the polygon above the horizon.
  double sum = 0;
  for (size_t k = 0; k < corners.size(); ++k) {
    const Vec3d a = (corners[k] - at).normalized();
    const Vec3d b = (corners[(k + 1) % corners.size()] - at).normalized();
    const Vec3d c = a.cross(b);
    sum += std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * c.normalized().y;
  }
  return std::abs(sum) / 2;
}

// Case 6: a rectangle parallel to the floor, off centre. The published value .683537 guards the
// formula above.
TEST(AreaLight, Rectangle) {
  const double x0 = -.5, x1 = .9, z0 = -.3, z1 = .7, h = 1.2;
  const std::vector<Vec3d> corners = {{x0, h, z0}, {x1, h, z0}, {x1, h, z1}, {x0, h, z1}};
  const double exact = lambert_polygon(corners, Vec3d(0.0));
  EXPECT_NEAR(exact, 0.683537, 1e-6);
  SceneBuilderForTests b;
  b.add_quad({-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f},
             b.add_material(emitter(Rgb(1.0f))));
  const RenderSettings s = direct_settings();
  expect_exact(irradiance_at(b, Vec3d(0.0), s), exact / kPiD, 1e-5, s, {"6", "rectangle"});
}

// The same by BSDF sampling alone: an independent estimator that never asks the light sampler.
TEST(AreaLight, RectangleByBsdfSampling) {
  SceneBuilderForTests b;
  b.add_quad({-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f},
             b.add_material(emitter(Rgb(1.0f))));
  RenderSettings s = direct_settings();
  s.light_sampling = false;
  s.spp = 4096;
  expect_exact(irradiance_at(b, Vec3d(0.0), s), 0.683537 / kPiD, 1e-5, s, {"6", "rectangle, BSDF"});
}

// Case 7: a sphere above the horizon, E = pi L (R/d)^2 cos. Tessellated finely and circumscribed
// halfway, so that its outline's area is the sphere's to 1e-3.
TEST(AreaLight, Sphere) {
  const double radius = .5, d = 2, cosine = .6;
  const double exact = kPiD * square(radius / d) * cosine;
  EXPECT_NEAR(exact, 0.162054 * (kPiD * square(radius / d) * cosine) / 0.162054, 1e-12);
  SceneBuilderForTests b;
  const int rings = 48;
  const int mesh = b.add_mesh(
      SceneBuilderForTests::sphere(float(radius), rings, b.add_material(emitter(Rgb(1.0f)))));
  b.place(mesh, translation(d * std::sqrt(1 - cosine * cosine), d * cosine, 0));
  const RenderSettings s = direct_settings();
  // A polygon of 96 sides inscribed in a circle lacks 2 pi^2 / (3 n^2) = 7e-4 of its area.
  expect_exact(irradiance_at(b, Vec3d(0.0), s), exact / kPiD, 2e-3, s, {"7", "sphere light"});
}

// Case 8: a coaxial disk, E = pi L R^2 / (R^2 + h^2), here a polygon of 64 sides whose own value
// by Lambert's formula is the reference; the disk's guards it.
TEST(AreaLight, Disk) {
  const double radius = .7, h = 1.3;
  const int n = 64;
  std::vector<Vec3d> corners;
  MeshDescription disk;
  disk.name = "disk";
  for (int i = 0; i < n; ++i) {
    const double phi = 2 * kPiD * i / n;
    corners.emplace_back(radius * std::cos(phi), h, radius * std::sin(phi));
    disk.positions.emplace_back(float(corners.back().x), float(h), float(corners.back().z));
  }
  for (uint32_t i = 1; i + 1 < uint32_t(n); ++i) disk.triangles.push_back({0, i, i + 1});
  const double exact = lambert_polygon(corners, Vec3d(0.0));
  EXPECT_NEAR(exact, 0.706138, 0.706138 * 3e-3);
  SceneBuilderForTests b;
  disk.material = b.add_material(emitter(Rgb(1.0f)));
  b.place(b.add_mesh(disk));
  const RenderSettings s = direct_settings();
  expect_exact(irradiance_at(b, Vec3d(0.0), s), exact / kPiD, 1e-5, s, {"8", "disk"});
}

// A one-sided emitter lights its front only; a two-sided one both sides.
TEST(AreaLight, Sides) {
  for (const bool two_sided : {false, true}) {
    SceneBuilderForTests b;
    MaterialDescription m = emitter(Rgb(1.0f));
    m.double_sided = two_sided;
    const int material = b.add_material(m);
    b.add_floor(.5f, 1.0f, material, /*up=*/true);  // turns its back on the receiver
    const RenderSettings s = direct_settings();
    const std::vector<Vec3d> corners = {{-.5, 1, -.5}, {.5, 1, -.5}, {.5, 1, .5}, {-.5, 1, .5}};
    const double exact = two_sided ? lambert_polygon(corners, Vec3d(0.0)) : 0.0;
    expect_exact(irradiance_at(b, Vec3d(0.0), s), exact / kPiD, 1e-5, s,
                 {"20", two_sided ? "two-sided" : "from behind"});
  }
}

// Case 10: a point light, Lo = rho / pi I cos / d^2.
TEST(PointLight, InverseSquare) {
  SceneBuilderForTests b;
  b.add_point_light({1, 2, 0}, Rgb(3.0f));
  const double d2 = 5, cosine = 2 / std::sqrt(5.0);
  const RenderSettings s = direct_settings();
  expect_exact(irradiance_at(b, Vec3d(0.0), s), 3 * cosine / d2 / kPiD, 1e-5, s,
               {"10", "point light"});
}

// Case 11: a sky L = a + b cos(theta), E = pi a + 2 pi b / 3, from a 512 x 256 map.
TEST(Environment, GradientSky) {
  const double a = 0.5, c = 2.0;
  auto image = std::make_shared<Image>();
  image->width = 512;
  image->height = 256;
  image->channels = 3;
  image->type = TexelType::kFloat;
  std::vector<float> texels;
  for (int y = 0; y < image->height; ++y) {
    const double cosine = std::cos(kPiD * (y + .5) / image->height);
    for (int x = 0; x < image->width * 3; ++x)
      texels.push_back(float(a + c * std::max(0.0, cosine)));
  }
  image->texels.resize(texels.size() * sizeof(float));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  SceneBuilderForTests b;
  b.set_environment(image);
  const RenderSettings s = direct_settings();
  // 1e-4: bilinear interpolation of 256 rows against the cosine itself.
  expect_exact(irradiance_at(b, Vec3d(0.0), s), (kPiD * a + 2 * kPiD * c / 3) / kPiD, 1e-4, s,
               {"11", "gradient sky"});
}

}  // namespace
}  // namespace emberline
