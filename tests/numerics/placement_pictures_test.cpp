// Cases 17 and 18 for a scene with everything in it. Its position and scale must not change the
// picture.

#include "closed_form.h"
#include "renderer/description/framing.h"
#include "renderer/statistics/error_metrics.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

std::shared_ptr<const Image> checks() {
  auto image = std::make_shared<Image>();
  image->width = image->height = 16;
  image->channels = 3;
  for (int i = 0; i < 16 * 16; ++i) {
    for (int c = 0; c < 3; ++c) {
      image->texels.push_back(std::byte((i + i / 16) % 2 ? 220 : 40 + 60 * c));
    }
  }
  return image;
}

// Renders a textured floor, two instances of a metal ball (one of them mirrored and stretched), a
// lamp, a spot light, an absorbing glass ball, a rough window pane and a sky. All are scaled by
// `scale` and moved to `at`.
RenderedImage picture(double scale, const Vec3d& at, uint32_t seed) {
  SceneBuilderForTests b;
  const auto placed = [&](const Mat44d& m) {
    return m * scaling(scale) * translation(at.x, at.y, at.z);
  };
  const auto quad = [&](const Vec3f& center, const Vec3f& u, const Vec3f& v, int material) {
    b.add_quad(center - u - v, center + u - v, center + u + v, center - u + v, material);
    b.description.instances.back().to_world = placed(Mat44d());
  };
  b.description.images.push_back(checks());
  MaterialDescription floor = lambert(Rgb(1.0f));
  floor.base_color_texture.image = 0;
  quad({0, 0, 0}, {3, 0, 0}, {0, 0, -3}, b.add_material(floor));
  quad({0, 3, 0}, {.5f, 0, 0}, {0, 0, .5f}, b.add_material(emitter({9, 8, 6})));

  const int ball = b.add_mesh(SceneBuilderForTests::sphere(
      .5f, 16, b.add_material(metal({.9f, .7f, .4f}, .4f)), false, true));
  b.place(ball, placed(translation(-1, .5, 0)));
  Mat44d stretched = scaling(.7);
  stretched[0][0] = -1.1;
  b.place(ball, placed(stretched * translation(.4, .5, -1)));
  MaterialDescription glass;
  glass.metallic = 0;
  glass.roughness = 0;
  glass.transmission = 1;
  glass.thin_walled = false;
  glass.attenuation_color = {.6f, .9f, .7f};
  glass.attenuation_distance = float(.5 * scale);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(.5f, 24, b.add_material(glass), false, true)),
          placed(translation(.5, .55, .8)));
  MaterialDescription pane = glass;
  pane.thin_walled = true;
  pane.roughness = .3f;
  quad({1.4f, .7f, 0}, {0, 0, -.5f}, {0, .5f, 0}, b.add_material(pane));
  PunctualLightDescription spot;
  spot.type = PunctualType::kSpot;
  spot.intensity = Rgb(float(8 * scale * scale));
  spot.outer_cone = .6f;
  spot.to_world = look_at_matrix({-2, 2.5, 2}, {0, 0, 0});
  for (int c = 0; c < 3; ++c) spot.to_world[3][c] = spot.to_world[3][c] * scale + at[c];
  b.description.lights.push_back(spot);
  b.set_environment({.3f, .4f, .5f});

  RenderSettings s;
  s.width = s.height = 64;
  s.spp = 64;
  s.seed = seed;
  s.max_depth = 12;
  return render(*b.build(),
                perspective(at + Vec3d(.5, 1.8, 5) * scale, at + Vec3d(0, .6, 0) * scale, 40), s);
}

RgbImage rgb_of(const RenderedImage& image) {
  RgbImage result{64, 64, {}};
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    for (size_t c = 0; c < 3; ++c) result.rgb.push_back(image.values[i + c]);
  }
  return result;
}

// The same seed gives the same paths, except where rounding moves a path past an edge or flips a
// random decision. So the mean changes by less than 1e-4. A picture at another place differs less
// than a picture with another seed.
class PlacedPicture : public testing::Test {
 protected:
  void compare(double scale, const Vec3d& at, const CaseName& name) {
    static const RenderedImage base = picture(1, Vec3d(0.0), 1);
    static const double noise =
        compare_images(rgb_of(picture(1, Vec3d(0.0), 2)), rgb_of(base)).rel_mse;
    const RenderedImage image = picture(scale, at, 1);
    const std::string replay = "seed 1, 64 spp, 64 x 64";
    expect_case({name.number, name.what + ", mean"}, {base.mean, image.mean, 0, 1e-4 * base.mean},
                replay);
    const double rel_mse = compare_images(rgb_of(image), rgb_of(base)).rel_mse;
    expect_case({name.number, name.what + ", relMSE against that of another seed"},
                {0, rel_mse, 0, noise}, replay);
    EXPECT_EQ(image.counters.non_finite_samples, 0u);
  }
};

TEST_F(PlacedPicture, Scale) {
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6}) {
    char text[64];
    std::snprintf(text, sizeof text, "everything, scale %g", scale);
    compare(scale, Vec3d(0.0), {"17", text});
  }
}

TEST_F(PlacedPicture, Distance) {
  for (const double distance : {1e4, 1e5, 1e7}) {
    char text[64];
    std::snprintf(text, sizeof text, "everything, moved by %g", distance);
    compare(1, Vec3d(distance, -.7 * distance, .4 * distance), {"18", text});
  }
}

// The scene is small and far away: a millimetre-sized scene in the coordinates of a city.
TEST_F(PlacedPicture, SmallAndFar) {
  compare(1e-3, Vec3d(3e4, 1e4, -2e4), {"E21", "everything, scale 1e-3 and moved by 4e4"});
}

}  // namespace
}  // namespace emberline
