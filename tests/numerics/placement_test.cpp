// Scale, distance, instancing and mirroring must not change the picture. There are no leaks, no
// self-hits, and no lost light.
#include "closed_form.h"

#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings placement_settings() {
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = 64;
  s.max_depth = 1000;
  return s;
}

Mat44d placed(double scale, const Vec3d& at, bool mirrored) {
  Mat44d m = scaling(scale);
  if (mirrored) m[0][0] = -m[0][0];
  for (int c = 0; c < 3; ++c) m[3][c] = at[c];
  return m;
}

// Renders a closed, emissive, reflecting sphere from inside. Its radiance is Le / (1 - rho)
// everywhere. A ray that leaks finds no light and a self-hit adds a bounce, so one leak in ten
// thousand rays shows.
RenderedImage cavity(double scale, const Vec3d& at, bool instanced, bool mirrored,
                     const RenderSettings& s) {
  SceneBuilderForTests b;
  MaterialDescription m = lambert(Rgb(0.8f));
  m.emission = Rgb(0.2f);
  const int mesh =
      b.add_mesh(SceneBuilderForTests::sphere(1.0f, 24, b.add_material(m), /*inward=*/true));
  b.place(mesh, placed(scale, at, mirrored));
  if (instanced) b.place(mesh, placed(scale, at + Vec3d(4 * scale, 0, 0), mirrored));
  const auto scene = b.build();
  return render(*scene, perspective(at, at + Vec3d(0.2, 0.1, -1) * scale, 90), s);
}

class Placement : public testing::TestWithParam<bool> {};

TEST_P(Placement, ScaleDoesNotShow) {
  const RenderSettings s = placement_settings();
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    expect_exact(cavity(scale, Vec3d(0.0), GetParam(), false, s), 1.0, 1e-5, s,
                 {"17", "scale " + std::to_string(scale)});
  }
}

TEST_P(Placement, DistanceFromTheOriginDoesNotShow) {
  const RenderSettings s = placement_settings();
  for (const double distance : {10.0, 1e4, 1e5, 1e7}) {
    expect_exact(cavity(1.0, Vec3d(distance, -distance, 0.5 * distance), GetParam(), false, s), 1.0,
                 1e-5, s, {"18", "distance " + std::to_string(distance)});
  }
}

TEST_P(Placement, MirrorDoesNotShow) {
  const RenderSettings s = placement_settings();
  expect_exact(cavity(1.0, Vec3d(0.0), GetParam(), true, s), 1.0, 1e-5, s, {"17", "mirrored"});
}

INSTANTIATE_TEST_SUITE_P(BakedAndInstanced, Placement, testing::Bool(),
                         [](const auto& p) { return p.param ? "instanced" : "baked"; });

// Scaling the scene by s and the intensities by s^2 leaves irradiance unchanged.
TEST(PlacementOfLights, PointLightScales) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    SceneBuilderForTests b;
    b.add_floor(float(10 * scale), 0, b.add_material(lambert(Rgb(1.0f))));
    b.add_point_light({0, 2 * scale, 0}, Rgb(float(3 * scale * scale)));
    const auto scene = b.build();
    RenderSettings s = placement_settings();
    s.max_depth = 1;
    expect_exact(render(*scene, orthographic({0, scale, 0}, {0, 0, 0}, 1e-4 * scale), s),
                 3.0 / 4 / kPiD, 1e-5, s, {"17", "point light at scale " + std::to_string(scale)});
  }
}

// A scene gives the same picture up to rounding if it is far away or scaled, provided that the
// seeds are equal.
TEST(PlacementOfPictures, FarSceneLooksTheSame) {
  const auto picture = [](double distance, double scale) {
    SceneBuilderForTests b;
    const int floor = b.add_mesh([&] {
      MeshDescription mesh;
      mesh.name = "floor";
      mesh.material = b.add_material(lambert({0.7f, 0.6f, 0.5f}));
      for (const float x : {-3.0f, 3.0f}) mesh.positions.emplace_back(x, 0.0f, 3.0f);
      for (const float x : {3.0f, -3.0f}) mesh.positions.emplace_back(x, 0.0f, -3.0f);
      mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
      return mesh;
    }());
    const Vec3d at(distance, distance, -distance);
    b.place(floor, placed(scale, at, false));
    b.place(b.add_mesh(SceneBuilderForTests::sphere(
                0.5f, 16, b.add_material(metal({0.9f, 0.7f, 0.4f}, 0.4f)), false, true)),
            placed(scale, at + Vec3d(0, 0.5, 0) * scale, false));
    b.set_environment({0.8f, 0.9f, 1.0f});
    RenderSettings s = placement_settings();
    s.width = s.height = 32;
    s.max_depth = 8;
    return render(*b.build(), perspective(at + Vec3d(0.5, 1.5, 4) * scale, at, 40), s);
  };
  const RenderedImage near = picture(0, 1);
  for (const auto& [distance, scale] :
       {std::pair{1e5, 1.0}, std::pair{1e7, 1.0}, std::pair{0.0, 1e-6}, std::pair{0.0, 1e6}}) {
    const RenderedImage other = picture(distance, scale);
    // Rounding changes single hits at edges and single roulette decisions, but not the mean.
    EXPECT_NEAR(other.mean, near.mean, 1e-4 * near.mean)
        << "distance " << distance << " scale " << scale;
  }
}

// Single-sided faces are invisible from behind for all rays, unless backfaces are shown.
TEST(Backfaces, CulledForEveryRay) {
  for (const bool shown : {false, true}) {
    SceneBuilderForTests b;
    b.add_floor(10, 0, b.add_material(lambert(Rgb(1.0f))));
    // The roof faces up, so it is invisible from below and lets light pass.
    b.add_floor(10, 1, b.add_material(lambert(Rgb(0.0f))), /*up=*/true);
    b.set_environment(Rgb(1.0f));
    SceneBuildOptions options;
    options.show_backfaces = shown;
    const auto scene = b.build(options);
    RenderSettings s = placement_settings();
    s.max_depth = 1;
    const RenderedImage image = render(*scene, orthographic({0, 0.5, 0}, {0, 0, 0}, 0.01), s);
    if (shown) {
      // Only the rim of sky between the roof's edge and the horizon is left.
      EXPECT_LT(image.mean, 0.05);
    } else {
      expect_exact(image, 1.0, 1e-5, s, {"20", "seen and lit through the back of the roof"});
    }
  }
}

// Coverage decides whether a camera ray passes, and whether a shadow ray passes.
TEST(Coverage, BlendWeighsCameraAndShadowRays) {
  const double alpha = 0.3;
  SceneBuilderForTests b;
  b.add_floor(10, 0, b.add_material(lambert(Rgb(1.0f))));
  MaterialDescription veil = lambert(Rgb(0.0f));
  veil.alpha = float(alpha);
  veil.alpha_mode = AlphaMode::kBlend;
  veil.double_sided = true;
  // The quad is off centre, since a ray on its diagonal would hit both of its triangles.
  b.add_quad({-3, 1, 8}, {8, 1, 8}, {8, 1, -3}, {-3, 1, -3}, b.add_material(veil));
  b.add_point_light({1, 3, 0}, Rgb(9.0f));
  const auto scene = b.build();
  RenderSettings s = placement_settings();
  s.max_depth = 1;
  s.spp = 1024;
  // The camera is above the veil, so its rays and the shadow rays each pass with probability 1 -
  // alpha.
  const double exact = (1 - alpha) * (1 - alpha) / kPiD;
  expect_exact(render(*scene, orthographic({1, 2, 0}, {1, 0, 0}, 1e-3), s), exact, 1e-4, s,
               {"17", "blend"});
}

}  // namespace
}  // namespace emberline
