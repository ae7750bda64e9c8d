// Tests the channel specular_velocity against scenes without mirrors and panes: mirror images are
// replaced by objects, and panes are left out.
#include <gtest/gtest.h>

#include "support/glass_scenes.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kSide = 24;

// A square of side 2 `half` around the origin in the plane z = 0. `bend` is the tangent of the
// angle by which its shading normals turn from the centre to the middle of a side.
MeshDescription square_mesh(int material, float half, float bend = 0) {
  MeshDescription mesh;
  mesh.positions = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = material;
  if (bend > 0) {
    for (const Vec3f& p : mesh.positions)
      mesh.normals.push_back(normalize(Vec3f(bend * p.x, bend * p.y, half)));
  }
  return mesh;
}

// Squares at an instant and one frame later.
struct MovingSquares {
  SceneBuilderForTests builder;

  void add(const MaterialDescription& material, float half, const Mat44d& from, const Mat44d& to,
           float bend = 0) {
    MaterialDescription both_sides = material;
    both_sides.double_sided = true;
    const int mesh = builder.add_mesh(square_mesh(builder.add_material(both_sides), half, bend));
    const auto instance = uint32_t(builder.description.instances.size());
    builder.place(mesh, from);
    builder.description.next_frame_instances.push_back({instance, to});
  }
  RenderedImage seen(const CameraDescription& view) {
    RenderSettings s;
    s.width = s.height = kSide;
    s.spp = 16;
    s.aovs = "velocity,specular_velocity";
    return render(*builder.build(), view, s);
  }
};

// The mean over the pixels around the centre of velocity, of specular_velocity, or of both.
Vec3d mean_of(const RenderedImage& image, bool first, bool specular) {
  Vec3d sum(0.0);
  const auto add = [&](const char* channel, int component) {
    const auto at = std::ranges::find(image.channels, channel) - image.channels.begin();
    for (int y = kSide / 3; y < 2 * kSide / 3; ++y) {
      for (int x = kSide / 3; x < 2 * kSide / 3; ++x) {
        sum[component] += double(image.pixel(x, y)[at]) / (kSide * kSide / 9);
      }
    }
  };
  if (first) add("velocity.X", 0), add("velocity.Y", 1);
  if (specular) add("specular_velocity.X", 0), add("specular_velocity.Y", 1);
  return sum;
}

void expect_near(const Vec3d& found, const Vec3d& exact, const std::string& what) {
  EXPECT_GT(exact.length(), 0.1) << what;
  EXPECT_LT((found - exact).length(), 2e-3 * exact.length())
      << what << ": " << found.x << ", " << found.y << " instead of " << exact.x << ", " << exact.y;
}

Mat44d turned_about(const Vec3d& axis, double angle) { return Mat44d().setAxisAngle(axis, angle); }

// The reflection about the plane that `mirror` makes of the plane z = 0.
Mat44d image_in(const Mat44d& mirror) { return mirror.inverse() * scaling(1, 1, -1) * mirror; }

// The image of a moving lamp in a moving mirror.
TEST(SpecularVelocity, IsThatOfTheMirrorImage) {
  const CameraDescription view = perspective({0, 0, 5}, {0, 0, 0}, 12);
  const Mat44d lamp = translation(0, 0, 8), tilted = turned_about(Vec3d(0, 1, 0), .17);
  struct Case {
    const char* what;
    Mat44d lamp_to, mirror_to;
  } const cases[] = {
      {"lamp moves", translation(.2, -.1, 7.5), tilted},
      {"mirror moves", lamp, tilted * translation(.3, 0, .1)},
      {"mirror turns", lamp, turned_about(Vec3d(0, 1, 0), 0.01) * tilted},
      {"both", translation(-.1, .1, 8.5), turned_about(Vec3d(1, 0, 0), 0.02) * tilted},
  };
  for (const Case& c : cases) {
    MovingSquares reflected, direct;
    reflected.add(metal(Rgb(1.0f), 0), 3, tilted, c.mirror_to);
    reflected.add(emitter(Rgb(1.0f)), 9, lamp, c.lamp_to);
    direct.add(emitter(Rgb(1.0f)), 9, lamp * image_in(tilted), c.lamp_to * image_in(c.mirror_to));
    expect_near(mean_of(reflected.seen(view), true, true), mean_of(direct.seen(view), true, false),
                c.what);
  }
}

// The camera moves, and the scene is at rest.
TEST(SpecularVelocity, OfTwoMirrorsAndABackground) {
  CameraDescription view = perspective({0, 0, 5}, {0, 0, 0}, 12);
  view.next_frame = view.to_world * translation(.05, .02, -.1);
  // The first mirror is tilted, and the second is above the camera. Between them they show a lamp
  // beside the first mirror.
  const Mat44d rest, tilted = turned_about(Vec3d(0, 1, 0), .35), above = translation(0, 0, 7),
                     lamp = translation(12, 0, -1),
                     lamp_image = lamp * image_in(above) * image_in(tilted);
  MovingSquares reflected, direct;
  reflected.add(metal(Rgb(1.0f), 0), 1, tilted, tilted);
  reflected.add(metal(Rgb(1.0f), 0), 9, above, above);
  reflected.add(emitter(Rgb(1.0f)), 6, lamp, lamp);
  direct.add(emitter(Rgb(1.0f)), 6, lamp_image, lamp_image);
  expect_near(mean_of(reflected.seen(view), true, true), mean_of(direct.seen(view), true, false),
              "two mirrors");

  // A mirror shows the sky, which moves only if the camera turns.
  CameraDescription turning = perspective({0, 0, 5}, {0, 0, 0}, 12);
  turning.next_frame =
      turned_about(Vec3d(0, 0, 1), .01) * turned_about(Vec3d(0, 1, 0), .004) * turning.to_world;
  MovingSquares mirror, nothing;
  mirror.add(metal(Rgb(1.0f), 0), 9, rest, rest);
  nothing.add(emitter(Rgb(1.0f)), .001f, translation(50, 0, 0), translation(50, 0, 0));
  expect_near(mean_of(mirror.seen(turning), true, true),
              mean_of(nothing.seen(turning), true, false), "sky in a mirror");
}

TEST(SpecularVelocity, BehindAPane) {
  const CameraDescription view = perspective({0, 0, 5}, {0, 0, 0}, 12);
  const Mat44d rest, lamp = translation(0, 0, -3), lamp_to = translation(.2, .1, -3.5);
  // It reflects nothing, so all paths go through.
  MaterialDescription pane = glass(1.0f, 0.0f, false);
  MovingSquares behind, alone;
  behind.add(pane, 3, rest, translation(-.3, 0, 0));
  behind.add(emitter(Rgb(1.0f)), 9, lamp, lamp_to);
  alone.add(emitter(Rgb(1.0f)), 9, lamp, lamp_to);
  expect_near(mean_of(behind.seen(view), true, true), mean_of(alone.seen(view), true, false),
              "pane");
}

// Where the motion is unknown, the mirror's own motion must remain.
TEST(SpecularVelocity, IsZeroElsewhere) {
  const CameraDescription view = perspective({0, 0, 5}, {0, 0, 0}, 12);
  const Mat44d rest, lamp = translation(0, 0, 8), lamp_to = translation(.2, .1, 8);
  const std::pair<MaterialDescription, float> rows[] = {
      {metal(Rgb(1.0f), 0), 1},      // curved
      {metal(Rgb(1.0f), 0), 0.02f},  // slightly, as a triangle of a fine mesh
      {metal(Rgb(1.0f), 0.3f), 0},   // rough
      {lambert(Rgb(0.5f)), 0}};
  for (const auto& [material, bend] : rows) {
    SCOPED_TRACE(material.roughness);
    MovingSquares scene;
    scene.add(material, 3, rest, translation(.1, 0, 0), bend);
    scene.add(emitter(Rgb(1.0f)), 9, lamp, lamp_to);
    const RenderedImage image = scene.seen(view);
    EXPECT_GT(mean_of(image, true, false).length(), 0.1);
    EXPECT_EQ(mean_of(image, false, true).length(), 0.0);
  }
}

}  // namespace
}  // namespace emberline
