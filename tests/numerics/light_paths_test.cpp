// Difficult light paths: large tilted emitters, emitters with holes, lamps behind and inside glass.
#include <cstring>

#include "receiver.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// Makes a square of half size h around `center` that faces n, cut into cuts x cuts quads.
MeshDescription tilted_square(const Vec3f& center, const Vec3f& n, float h, int cuts,
                              int material) {
  const Vec3f u = normalize(cross(n, Vec3f(0.3f, 0.1f, 0.9f)));
  const Vec3f v = normalize(cross(u, n));
  MeshDescription mesh;
  mesh.name = "tilted";
  mesh.material = material;
  for (int j = 0; j <= cuts; ++j) {
    for (int i = 0; i <= cuts; ++i) {
      const float a = h * (2.0f * float(i) / float(cuts) - 1),
                  b = h * (2.0f * float(j) / float(cuts) - 1);
      mesh.positions.push_back(center + u * a + v * b);
    }
  }
  const auto at = [&](int i, int j) { return uint32_t(j * (cuts + 1) + i); };
  for (int j = 0; j < cuts; ++j) {
    for (int i = 0; i < cuts; ++i) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  }
  return mesh;
}

// A large emitter must not shadow itself anywhere. A square of two triangles gives the same light
// as the square in 64 x 64 pieces, and the same as BSDF sampling, which needs no shadow rays.
TEST(LightPaths, LargeTiltedEmitterDoesNotShadeItself) {
  // There are several tilts, since rounding decides for which tilts points on the emitter end on
  // its wrong side.
  for (const auto& [direction, half, distance] :
       {std::tuple{Vec3f(0.35f, 1.0f, -0.55f), 10.0f, 1.0f},
        std::tuple{Vec3f(0.6f, 1.0f, 0.2f), 10.0f, 0.1f},
        std::tuple{Vec3f(-0.4f, 1.0f, 0.7f), 10.0f, 0.1f},
        std::tuple{Vec3f(0.1f, 1.0f, 0.3f), 1.0f, 0.03f},
        std::tuple{Vec3f(-0.8f, 1.0f, -0.3f), 50.0f, 1.0f}}) {
    const Vec3f n = normalize(direction);
    const Vec3f center = n * 0.013f;
    const auto picture = [&](int cuts, bool instanced, bool light_sampling) {
      SceneBuilderForTests b;
      const int lamp =
          b.add_mesh(tilted_square(center, -n, half, cuts, b.add_material(emitter(Rgb(1.0f)))));
      b.place(lamp);
      if (instanced) b.place(lamp, translation(0, 1e3, 0));
      // The receiver is parallel to the lamp and below it.
      b.place(b.add_mesh(
          tilted_square(center - n * distance, n, 0.01f, 1, b.add_material(lambert(Rgb(1.0f))))));
      const auto scene = b.build();
      RenderSettings s = direct_light_settings();
      s.light_samples = light_sampling ? 1 : 0;
      const Vec3f receiver = center - n * distance;
      const Vec3d at(receiver.x, receiver.y, receiver.z);
      const Vec3d up(n.x, n.y, n.z);
      return render(*scene, orthographic(at + up * (0.4 * distance), at, 1e-3), s);
    };
    const RenderedImage bsdf = picture(1, false, false);
    EXPECT_GT(bsdf.mean, 0.5);
    for (const auto& [cuts, instanced] :
         {std::pair{1, false}, std::pair{64, false}, std::pair{1, true}}) {
      const RenderedImage lit = picture(cuts, instanced, true);
      EXPECT_NEAR(lit.mean, bsdf.mean,
                  5 * std::hypot(lit.standard_error, bsdf.standard_error) + 1e-4)
          << "half size " << half << " distance " << distance << " in " << cuts << "^2 pieces"
          << (instanced ? ", instanced" : "");
    }
  }
}

// A blended card is bright where it is clear. A light sample must use the product of the mean
// emission and the mean coverage, as rays do, not the mean of the product (0 here).
TEST(LightPaths, BlendedEmitterIsSampledAsItIsSeen) {
  const auto picture = [](bool light_sampling) {
    SceneBuilderForTests b;
    auto image = std::make_shared<Image>();
    image->width = 2;
    image->height = 1;
    image->channels = 4;
    image->texels.resize(8);
    const uint8_t texels[8] = {255, 255, 255, 0,
                               0,   0,   0,   255};  // white and clear, black and opaque
    std::memcpy(image->texels.data(), texels, 8);
    b.description.images.push_back(image);
    MaterialDescription m = emitter(Rgb(10.0f));
    m.emission_texture.image = 0;
    m.base_color_texture.image = 0;
    m.alpha_mode = AlphaMode::kBlend;
    m.double_sided = true;
    const int material = b.add_material(m);
    b.add_quad({-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}, material);
    b.add_floor(10, 0, b.add_material(lambert(Rgb(1.0f))));
    const auto scene = b.build();
    RenderSettings s = direct_light_settings();
    s.light_samples = light_sampling ? 1 : 0;
    s.spp = 4096;
    return render(*scene, orthographic({.2, .5, .1}, {.2, 0, .1}, 1e-4), s);
  };
  const RenderedImage both = picture(true), bsdf = picture(false);
  EXPECT_GT(bsdf.mean, 0.1);
  EXPECT_NEAR(both.mean, bsdf.mean, 5 * std::hypot(both.standard_error, bsdf.standard_error));
}

MaterialDescription pane(float roughness, bool thin) {
  MaterialDescription m;
  m.base_color = Rgb(0.8f);
  m.metallic = 0.0f;
  m.roughness = roughness;
  m.transmission = 1.0f;
  m.thin_walled = thin;
  return m;
}

// A point light behind window panes can illuminate the floor only straight through the panes. At
// normal incidence a thin pane transmits 1 - R of the tint, where R is that of one interface, as in
// glTF.
TEST(LightPaths, PointLightShinesThroughThinPanes) {
  for (const int panes : {1, 2}) {
    SceneBuilderForTests b;
    b.add_floor(10, 0, b.add_material(lambert(Rgb(1.0f))));
    const int glass = b.add_material(pane(0, true));
    for (int i = 0; i < panes; ++i) {
      const float y = 1.0f + 0.3f * float(i);
      b.add_quad({-3, y, 8}, {8, y, 8}, {8, y, -3}, {-3, y, -3}, glass);
    }
    b.add_point_light({1, 3, 0}, Rgb(9.0f));
    const auto scene = b.build();
    const RenderSettings s = direct_light_settings();
    const double r = square(0.5 / 2.5);
    const double exact = std::pow(0.8 * (1 - r), panes) / kPiD;
    expect_exact(render(*scene, orthographic({1, .5, 0}, {1, 0, 0}, 1e-3), s), exact, 1e-4, s,
                 {"13", "thin walls, " + std::to_string(panes) + " panes"});
  }
}

// A lamp and a plate are inside a tinted solid of index 1 and seen from outside. The solid absorbs
// along the segment to the plate and along the segment to the lamp.
TEST(LightPaths, AbsorptionOnEveryLeg) {
  for (const bool light_sampling : {true, false}) {
    SceneBuilderForTests b;
    MaterialDescription m = pane(0, false);
    m.base_color = Rgb(1.0f);
    m.ior = 1.0f;
    m.attenuation_color = Rgb(0.5f);
    m.attenuation_distance = 1.0f;
    const int solid = b.add_material(m);
    b.add_floor(50, 3, solid, /*up=*/true);
    b.add_floor(50, -3, solid, /*up=*/false);
    b.add_floor(1, 0, b.add_material(lambert(Rgb(1.0f))));
    b.add_quad({-.05f, 2, -.05f}, {.05f, 2, -.05f}, {.05f, 2, .05f}, {-.05f, 2, .05f},
               b.add_material(emitter(Rgb(400.0f))));
    const auto scene = b.build();
    RenderSettings s = direct_light_settings();
    s.light_samples = light_sampling ? 1 : 0;
    s.max_depth = 2;  // through the surface, then at the plate
    s.spp = light_sampling ? 1024 : long_or_short(65536, 16384);
    const double d2 = 4 + square(.3) + square(.1);
    const double lit = 400 * 0.01 * (4 / d2) / d2 / kPiD;  // L A cos^2 / d^2, over pi
    const double exact = lit * std::pow(0.5, 3.0) * std::pow(0.5, std::sqrt(d2));
    // The tolerance is 1e-3, since the lamp's far corners are farther away than its centre.
    expect_exact(render(*scene, orthographic({.3, 5, .1}, {.3, 0, .1}, 1e-3), s), exact, 1e-3, s,
                 {"26", light_sampling ? "lamp in a medium, light sampling"
                                       : "lamp in a medium, BSDF sampling"});
  }
}

// The camera is inside the solid, which the ray recognises when it hits the back of a face.
TEST(LightPaths, CameraInsideASolid) {
  SceneBuilderForTests b;
  MaterialDescription m = pane(0, false);
  m.base_color = Rgb(1.0f);
  m.ior = 1.0f;
  m.attenuation_color = Rgb(0.5f);
  m.attenuation_distance = 1.0f;
  const int solid = b.add_material(m);
  b.add_floor(50, 3, solid, /*up=*/true);
  b.add_floor(50, -3, solid, /*up=*/false);
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const RenderSettings s = direct_light_settings();
  expect_exact(render(*scene, orthographic({.3, 1, .1}, {.3, 2, .1}, 1e-3), s), 0.25, 1e-5, s,
               {"26", "camera inside, two metres of glass above"});
}

}  // namespace
}  // namespace emberline
