// Tests the pixels that are reported as empty: none of their camera rays hits a surface, and most
// are found.
#include "renderer/scene/empty_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "support/render.h"
#include "support/scenes.h"

namespace emberline::test {
namespace {

constexpr int kWidth = 96, kHeight = 64;

// A transform with the given scale and translation, rotated if `turned`.
Mat44d placed(const Vec3d& size, const Vec3d& at, bool turned = true) {
  Mat44d m, turn;
  m.setScale(size);
  if (turned) turn.setEulerAngles(Vec3d(0.4, 1.1, -0.3));
  m = m * turn;
  for (int c = 0; c < 3; ++c) m[3][c] = at[c];
  return m;
}

// A view of balls (two instances of one mesh, one of them stretched) and of a floor that extends
// below and behind the camera. Everything is scaled by `size` and moved.
struct View {
  SceneBuilderForTests builder;
  CameraDescription camera;

  explicit View(double size, const Vec3d& moved = Vec3d(0.0)) {
    const int material = builder.add_material(lambert(Rgb(0.5f)));
    const auto at = [&](double x, double y, double z) { return moved + Vec3d(x, y, z) * size; };
    const int ball = builder.add_mesh(builder.sphere(1.0f, 24, material));
    builder.place(ball, placed(Vec3d(0.4 * size), at(-0.9, 0.3, 0)));
    builder.place(ball, placed(Vec3d(0.6, 0.03, 0.2) * size, at(0.7, 0.6, 0)));
    const int small = builder.add_mesh(builder.sphere(0.2f, 5, material));
    builder.place(small, placed(Vec3d(size), at(0, 0.9, 1)));
    builder.add_floor(9, 0, material);
    builder.description.instances.back().to_world = placed(Vec3d(size), at(0, -1, 0), false);
    camera = perspective(at(0.2, 0.4, 4), at(0, 0.5, 0), 40);
  }
};

struct Traced {
  std::unique_ptr<Scene> scene;
  Camera camera;
  Traced(const SceneBuilderForTests& builder, const CameraDescription& view)
      : scene(builder.build()),
        camera(view, kWidth, kHeight, scene->origin(), scene->scale(), scene->max_origin()) {}
  explicit Traced(const View& view) : Traced(view.builder, view.camera) {}
  std::shared_ptr<const EmptyPixels> empty(float reach) const {
    return EmptyPixels::find(*scene, camera, kWidth, kHeight, reach);
  }
  bool meets(float x, float y) const {
    SurfaceHit hit;
    return scene->intersect(camera.ray({x, y}), CoverageKey(), &hit);
  }
};

// Counts the rays of a pixel that hit something. Nine rays go to the corners, sides and centre of
// the filter, and `count` rays are random.
int count_hits(const Traced& traced, int x, int y, float reach, int count, std::mt19937& random) {
  int found = 0;
  const auto look = [&](float dx, float dy) {
    found += traced.meets(float(x) + 0.5f + dx * reach, float(y) + 0.5f + dy * reach);
  };
  for (const float dx : {-1.0f, 0.0f, 1.0f}) {
    for (const float dy : {-1.0f, 0.0f, 1.0f}) look(dx, dy);
  }
  const auto number = [&] { return float(random()) * 0x1p-31f - 1.0f; };
  for (int i = 0; i < count; ++i) look(number(), number());
  return found;
}

void expect_right(const View& view, float reach, const std::string& name) {
  const Traced traced(view);
  const auto empty = traced.empty(reach);
  ASSERT_TRUE(empty) << name;
  std::mt19937 random(5);
  int missed = 0, found = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (empty->contains(x, y)) {
        EXPECT_EQ(count_hits(traced, x, y, reach, 20, random), 0) << name << ": " << x << ", " << y;
        ++found;
      } else if (count_hits(traced, x, y, reach + 1, 20, random) == 0) {
        ++missed;
      }
    }
  }
  EXPECT_GT(found, kWidth * kHeight / 8) << name;
  EXPECT_LT(missed, found / 50) << name;
}

TEST(EmptyPixels, NoRayOfThemMeetsASurface) {
  expect_right(View(1), 0.5f, "box");
  expect_right(View(1), 1.5f, "wide filter");
  expect_right(View(1e-6), 0.5f, "tiny");
  expect_right(View(1e6), 0.5f, "huge");
  expect_right(View(1, Vec3d(1e7, -2e7, 3e6)), 0.5f, "far away");
  expect_right(View(1, Vec3d(3, -2, 5)), 0.5f, "a little aside");
}

// The camera is among triangles of all sizes, many of which cross its plane. The answer is right or
// unknown.
TEST(EmptyPixels, TrianglesNextToAndBehindTheCamera) {
  std::mt19937 random(3);
  const auto number = [&] { return float(random()) * 0x1p-31f - 1.0f; };
  int told = 0;
  for (int round = 0; round < 40; ++round) {
    SceneBuilderForTests builder;
    MaterialDescription material = lambert(Rgb(0.5f));
    material.double_sided = true;
    MeshDescription mesh;
    mesh.material = builder.add_material(material);
    for (uint32_t i = 0; i < 4; ++i) {
      const Vec3f at(number(), number(), number());
      const float size = std::exp2(3 * number());
      for (int c = 0; c < 3; ++c) {
        mesh.positions.push_back(at + Vec3f(number(), number(), number()) * size);
      }
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    builder.place(builder.add_mesh(std::move(mesh)));
    const Traced traced(builder, perspective(Vec3d(0.0), Vec3d(0.3, 0.1, -1), 70));
    const auto empty = traced.empty(0.5f);
    if (!empty) continue;
    ++told;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (!empty->contains(x, y)) continue;
        EXPECT_EQ(count_hits(traced, x, y, 0.5f, 4, random), 0) << round << ": " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(told, 20);
}

// A wall beside and behind the camera is visible only to filter samples far outside a tiny frame.
TEST(EmptyPixels, AFilterWiderThanTheFrame) {
  for (const int size : {1, 4, 8}) {
    for (const float reach : {1.5f, 6.0f, 32.0f}) {
      SceneBuilderForTests builder;
      MaterialDescription material = lambert(Rgb(0.5f));
      material.double_sided = true;
      MeshDescription mesh;
      mesh.material = builder.add_material(material);
      mesh.positions = {{-1, -9, 9}, {-1, 9, 9}, {-1, 0, -0.2f}};
      mesh.triangles.push_back({0, 1, 2});
      builder.place(builder.add_mesh(std::move(mesh)));
      const auto scene = builder.build();
      const Camera camera(perspective(Vec3d(0.0), Vec3d(0, 0, -1), 90), size, size, scene->origin(),
                          scene->scale(), scene->max_origin());
      const auto empty = EmptyPixels::find(*scene, camera, size, size, reach);
      const auto meets = [&](double film) {
        SurfaceHit hit;
        return scene->intersect(camera.ray({float(film), float(size) / 2}), CoverageKey(), &hit);
      };
      // The wall ends where x = 5 z, which is left of the frame's centre at this pixel.
      const double edge = size / 2.0 - 5.0 * size / 2.0;
      EXPECT_TRUE(meets(edge - 0.1));
      EXPECT_FALSE(meets(edge + 0.1));
      for (int x = 0; x < size; ++x) {
        const bool sees = x + 0.5 - double(reach) < edge;
        if (sees && empty) {
          EXPECT_FALSE(empty->contains(x, size / 2)) << size << ", " << reach;
        }
        if (x - double(reach) > edge + 1) {
          EXPECT_TRUE(empty && empty->contains(x, size / 2)) << size << ", " << reach;
        }
      }
    }
  }
}

TEST(EmptyPixels, AreSearchedOnlyIfOneProjectionShowsEverything) {
  View view(1);
  view.camera = orthographic(Vec3d(0.2, 0.4, 4), Vec3d(0, 0.5, 0), 2);
  const Traced flat(view);
  EXPECT_FALSE(flat.empty(0.5f));
  view = View(1);
  view.camera.lens_radius = 0.1;
  view.camera.focus_distance = 4;
  const Traced blurred(view);
  EXPECT_FALSE(blurred.empty(0.5f));
}

TEST(EmptyPixels, AreAbsentInsideABox) {
  SceneBuilderForTests builder;
  const int material = builder.add_material(lambert(Rgb(0.5f)));
  builder.place(builder.add_mesh(builder.sphere(5, 12, material, true)));
  const Traced traced(builder, perspective(Vec3d(0, 0, 1), Vec3d(0.0), 60));
  EXPECT_FALSE(traced.empty(0.5f));
}

}  // namespace
}  // namespace emberline::test
