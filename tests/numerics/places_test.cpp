// Tests the channels P and UV and the camera matrices. The matrices in the header transform a
// pixel's position to that pixel and to the depth in Z.
#include <gtest/gtest.h>

#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kWidth = 24, kHeight = 16;

RenderSettings settings() {
  RenderSettings s;
  s.width = kWidth;
  s.height = kHeight;
  s.spp = 16;
  s.aovs = "Z,P,UV";
  return s;
}

struct Places {
  RenderedImage image;
  Camera::WorldMatrices matrices;

  const float* at(int x, int y, const std::string& name) const {
    const auto i = std::ranges::find(image.channels, name) - image.channels.begin();
    return image.pixel(x, y) + i;
  }
  Vec3d position(int x, int y) const {
    const float* p = at(x, y, "P.X");
    return {double(p[0]), double(p[1]), double(p[2])};
  }
  bool hit(int x, int y) const { return *at(x, y, "Z") < kBackgroundDepth; }
};

Places places(const CameraDescription& view, const Vec3d& middle, const RenderSettings& s) {
  SceneBuilderForTests b;
  const int grey = b.add_material(lambert(Rgb(0.5f)));
  b.add_floor(3, -0.5f, grey);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.8f, 24, grey, false, true)));
  b.set_environment(Rgb(1.0f));
  for (InstanceDescription& instance : b.description.instances) {
    instance.to_world.setTranslation(middle);
  }
  const std::unique_ptr<Scene> scene = b.build({.unread_uv = true});
  const Camera camera(view, s.width, s.height, scene->origin(), scene->scale());
  return {render(*scene, view, s), camera.world_matrices(scene->origin())};
}

// `error` is the rounding error of a coordinate in float.
void expect_in_place(const Places& places, double error) {
  int hits = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (!places.hit(x, y)) {
        EXPECT_EQ(places.position(x, y), Vec3d(0.0));
        continue;
      }
      ++hits;
      Vec3d in_camera, ndc;
      places.matrices.to_camera.multVecMatrix(places.position(x, y), in_camera);
      places.matrices.to_ndc.multVecMatrix(places.position(x, y), ndc);  // divides by w
      const auto depth = double(*places.at(x, y, "Z"));
      EXPECT_NEAR(in_camera.z, depth, 1e-5 * depth + error) << x << "," << y;
      const double in_pixels = error / depth * kHeight;
      EXPECT_NEAR(ndc.x * kWidth, x + 0.5, 0.501 + in_pixels) << x << "," << y;
      EXPECT_NEAR(ndc.y * kHeight, y + 0.5, 0.501 + in_pixels) << x << "," << y;
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(Places, AreWhereTheMatricesPutThem) {
  const Vec3d eye(1.2, 0.9, 3);
  for (const Vec3d& middle : {Vec3d(0.0), Vec3d(3e4, -2e4, 1e4)}) {
    const double error = middle.length() * 0x1p-22;
    expect_in_place(
        places(perspective(middle + eye, middle + Vec3d(.1, 0, 0), 50), middle, settings()), error);
    expect_in_place(places(orthographic(middle + eye, middle, 1.5), middle, settings()), error);
  }
}

TEST(Places, OfAMirroredCameraToo) {
  CameraDescription view = perspective({1.2, 0.9, 3}, {0, 0, 0}, 50);
  for (int c = 0; c < 3; ++c) view.to_world[0][c] *= -1;
  expect_in_place(places(view, Vec3d(0.0), settings()), 1e-6);
}

// Lens rays start at different points of the lens. If they hit a point in focus, it lies within
// their pixel.
TEST(Places, OfWhatALensHasInFocus) {
  CameraDescription view = perspective({0, 4, 0.001}, {0, -0.5, 0}, 40);
  view.lens_radius = 0.3;
  view.focus_distance = 4.5;
  SceneBuilderForTests b;
  b.add_floor(30, -0.5f, b.add_material(lambert(Rgb(0.5f))));
  b.set_environment(Rgb(1.0f));
  const std::unique_ptr<Scene> scene = b.build();
  const Camera camera(view, kWidth, kHeight, scene->origin(), scene->scale());
  expect_in_place({render(*scene, view, settings()), camera.world_matrices(scene->origin())}, 1e-5);
}

// The quad fills the frame. U grows to the right and V upwards.
TEST(Uv, IsTheFirstSetsWithVUpwards) {
  SceneBuilderForTests b;
  const int grey = b.add_material(lambert(Rgb(0.5f)));
  // In glTF, whose V points down, the corners have the UV (0, 0), (1, 0), (1, 1), (0, 1), starting
  // at the upper left.
  b.add_quad({-1.5f, 1, 0}, {1.5f, 1, 0}, {1.5f, -1, 0}, {-1.5f, -1, 0}, grey);
  b.description.materials[size_t(grey)].double_sided = true;
  b.set_environment(Rgb(1.0f));
  const CameraDescription view = orthographic({0, 0, 5}, {0, 0, 0}, 1);
  const RenderSettings s = settings();
  const auto uv = [&](bool kept) {
    const std::unique_ptr<Scene> scene = b.build({.unread_uv = kept});
    return Places{render(*scene, view, s), {}};
  };
  const Places seen = uv(plan_of(s).build.unread_uv), without = uv(false);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float* t = seen.at(x, y, "UV.U");
      EXPECT_NEAR(t[0], (x + 0.5) / kWidth, 0.5 / kWidth);
      EXPECT_NEAR(t[1], 1 - (y + 0.5) / kHeight, 0.5 / kHeight);
      EXPECT_EQ(without.at(x, y, "UV.U")[1], 0.0f);
    }
  }
}

}  // namespace
}  // namespace emberline
