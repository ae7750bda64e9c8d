// Coplanar surfaces: lamps flush with their mounting, and duplicated meshes.
#include "closed_form.h"

#include "support/closed_forms.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// A flush lamp counts as being in front of its wall on every side that emits. So it gives the
// irradiance of the same rectangle in empty space (Lambert's polygon formula), and the camera sees
// the whole lamp. The wall is black, so all light comes from the lamp.
struct Mounting {
  const char* name;
  double tilt;  // rotates the whole scene about an oblique axis
  Vec3d at;     // then moves it
  float wall;   // half size of the wall; the lamp's is .5
  bool wall_two_sided, lamp_two_sided, instanced;
};

// Returns a rotation about (1, 2, 3) / sqrt 14 by Rodrigues' formula, followed by a translation,
// for row vectors.
Mat44d oblique(double angle, const Vec3d& at) {
  const Vec3d k = Vec3d(1, 2, 3).normalized();
  const double c = std::cos(angle), s = std::sin(angle);
  const double cross_matrix[3][3] = {{0, k.z, -k.y}, {-k.z, 0, k.x}, {k.y, -k.x, 0}};
  Mat44d m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      m[i][j] = c * (i == j) + s * cross_matrix[i][j] + (1 - c) * k[i] * k[j];
    }
    m[3][i] = at[i];
  }
  return m;
}

MeshDescription square_mesh(float half, float y, bool up, int material) {
  MeshDescription mesh;
  mesh.name = "square";
  mesh.material = material;
  for (const float x : {-half, half}) mesh.positions.emplace_back(x, y, half);
  for (const float x : {half, -half}) mesh.positions.emplace_back(x, y, -half);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  if (!up) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

constexpr float kCeiling = 2.5f;

std::unique_ptr<Scene> mounted(const Mounting& m, int lamps) {
  SceneBuilderForTests b;
  const Mat44d placed = oblique(m.tilt, m.at);
  MaterialDescription wall = lambert(Rgb(0.0f)), lamp = emitter(Rgb(1.0f));
  wall.double_sided = m.wall_two_sided;
  lamp.double_sided = m.lamp_two_sided;
  b.place(b.add_mesh(square_mesh(m.wall, kCeiling, false, b.add_material(wall))), placed);
  const int lamp_mesh = b.add_mesh(square_mesh(.5f, kCeiling, false, b.add_material(lamp)));
  for (int i = 0; i < lamps; ++i) b.place(lamp_mesh, placed);
  // A second use of the mesh, out of sight, makes the lamp an instance.
  if (m.instanced) b.place(lamp_mesh, translation(0, 0, 300) * placed);
  b.place(b.add_mesh(square_mesh(1, 0, true, b.add_material(lambert(Rgb(1.0f))))), placed);
  return b.build();
}

CameraDescription straight_down(const Mounting& m) {
  CameraDescription view = orthographic({.2, .7, .1}, {.2, 0, .1}, 1e-4);
  view.to_world = view.to_world * oblique(m.tilt, m.at);
  return view;
}

double exact_radiance() {
  const double h = kCeiling;
  return polygon_irradiance({{-.5, h, -.5}, {.5, h, -.5}, {.5, h, .5}, {-.5, h, .5}}, {.2, 0, .1},
                            {0, 1, 0}) /
         kPiD;
}

const Mounting kMountings[] = {
    {"on a ceiling of 4 m", 0, {0, 0, 0}, 2, false, true, false},
    {"on a ceiling of 4 m, tilted", .7, {0, 0, 0}, 2, false, true, false},
    {"on a two-sided wall of 200 m, tilted", 1.1, {3, -2, 5}, 100, true, true, false},
    {"one-sided, on a wall of 4 km, tilted", 1.9, {0, 0, 0}, 2000, true, false, false},
    {"larger than its wall, tilted", 2.3, {0, 0, 0}, .3f, false, true, false},
    {"instanced, on a wall of 200 m, tilted", .4, {3, -2, 5}, 100, false, true, true}};

TEST(FlushLamp, LightsItsHalfSpace) {
  RenderSettings s;
  s.width = s.height = 8;
  s.max_depth = 1;
  for (const Mounting& m : kMountings) {
    const auto scene = mounted(m, 1);
    for (const bool light_sampling : {true, false}) {
      s.light_samples = light_sampling ? 1 : 0;
      s.spp = light_sampling ? 1024 : long_or_short(8192, 2048);
      expect_exact(
          render(*scene, straight_down(m), s), exact_radiance(), 1e-5, s,
          {"20", std::string("flush lamp ") + m.name + (light_sampling ? "" : ", BSDF sampling")});
    }
  }
}

// No pixel of the lamp shows the wall.
TEST(FlushLamp, IsSeenWhole) {
  RenderSettings s;
  s.width = s.height = 64;
  s.max_depth = 1;
  for (const Mounting& m : kMountings) {
    CameraDescription view = perspective({.2, .7, .1}, {.1, kCeiling, .05}, 18);
    view.to_world = view.to_world * oblique(m.tilt, m.at);
    expect_exact(render(*mounted(m, 1), view, s), 1.0, 0, s,
                 {"20", std::string("flush lamp seen, ") + m.name});
  }
}

// Two or three copies of a lamp in the same place shine like one lamp.
TEST(FlushLamp, DoubledShinesOnce) {
  RenderSettings s;
  s.width = s.height = 8;
  s.max_depth = 1;
  for (const int lamps : {2, 3}) {
    for (const Mounting& m : kMountings) {
      const auto scene = mounted(m, lamps);
      for (const bool light_sampling : {true, false}) {
        if (lamps == 3 && !light_sampling) continue;
        s.light_samples = light_sampling ? 1 : 0;
        s.spp = light_sampling ? 1024 : long_or_short(8192, 2048);
        expect_exact(render(*scene, straight_down(m), s), exact_radiance(), 1e-5, s,
                     {"20", std::to_string(lamps) + " lamps in one another, " + m.name +
                                (light_sampling ? "" : ", BSDF sampling")});
      }
    }
  }
}

// An emissive decal of alpha .3, flush with its wall, gives .3 of the irradiance. Light samples are
// weighted by the decal's coverage, whereas a ray hits the decal with probability .3. Both must
// agree.
TEST(FlushLamp, CoversByItsAlpha) {
  for (const bool light_sampling : {true, false}) {
    SceneBuilderForTests b;
    const Mat44d placed = oblique(.7, {1, 2, 3});
    MaterialDescription decal = emitter(Rgb(1.0f));
    decal.alpha = .3f;
    decal.alpha_mode = AlphaMode::kBlend;
    b.place(b.add_mesh(square_mesh(30, kCeiling, false, b.add_material(lambert(Rgb(0.0f))))),
            placed);
    b.place(b.add_mesh(square_mesh(.5f, kCeiling, false, b.add_material(decal))), placed);
    b.place(b.add_mesh(square_mesh(1, 0, true, b.add_material(lambert(Rgb(1.0f))))), placed);
    const auto scene = b.build();
    CameraDescription view = orthographic({.2, .7, .1}, {.2, 0, .1}, 1e-4);
    view.to_world = view.to_world * placed;
    RenderSettings s;
    s.width = s.height = 8;
    s.max_depth = 1;
    s.light_samples = light_sampling ? 1 : 0;
    s.spp = light_sampling ? 4096 : long_or_short(16384, 4096);
    expect_exact(render(*scene, view, s), .3 * exact_radiance(), 1e-5, s,
                 {"20", light_sampling ? "flush decal of alpha .3"
                                       : "flush decal of alpha .3, BSDF sampling"});
  }
}

// A reflecting lamp is flush with a reflecting ceiling. A ray that leaves one of the two must not
// hit the other at once. In a closed room that emits .2 and reflects .8 everywhere, the radiance is
// Le / (1 - rho) = 1. An extra bounce, or light counted twice, would change this value.
TEST(FlushLamp, ReflectsOnce) {
  SceneBuilderForTests b;
  const Mat44d placed = oblique(1.3, {20, -3, 5});
  MaterialDescription m = lambert(Rgb(.8f));
  m.emission = Rgb(.2f);
  const int material = b.add_material(m);
  // The room is a box of side 40. Its ceiling carries a flush square of half size .5.
  MeshDescription room;
  room.name = "room";
  room.material = material;
  for (int i = 0; i < 8; ++i) {
    room.positions.emplace_back(i & 1 ? 20.0f : -20.0f, i & 2 ? 20.0f : -20.0f,
                                i & 4 ? 20.0f : -20.0f);
  }
  room.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  for (auto& t : room.triangles) std::swap(t[1], t[2]);
  b.place(b.add_mesh(room), placed);
  b.place(b.add_mesh(square_mesh(.5f, 20, false, material)), placed);
  const auto scene = b.build();
  for (const bool light_sampling : {true, false}) {
    CameraDescription view = perspective({.2, 19.0, .1}, {.1, 20, .05}, 30);
    view.to_world = view.to_world * placed;
    RenderSettings s;
    s.spp = 64;
    s.max_depth = 1000;
    s.light_samples = light_sampling ? 1 : 0;
    expect_exact(render(*scene, view, s), 1.0, 1e-5, s,
                 {"20", light_sampling ? "reflecting lamp in a reflecting ceiling"
                                       : "reflecting lamp in a reflecting ceiling, BSDF sampling"});
  }
}

// A small tile is flush with a floor a thousand times as large, in a furnace. The error bound of
// the tile is smaller than that of the floor. A ray that leaves the tile by the tile's bound must
// not hit the floor, or the result is .5 x .5 instead of .5.
TEST(Coplanar, SmallTileOnALargeFloor) {
  SceneBuilderForTests b;
  const int material = b.add_material(lambert(Rgb(.5f)));
  const Mat44d placed = oblique(.9, {0, 0, 0});
  b.place(b.add_mesh(square_mesh(500, 0, true, material)), placed);
  b.place(b.add_mesh(square_mesh(.5f, 0, true, material)), placed);
  b.set_environment(Rgb(1.0f));
  CameraDescription view = orthographic({.1, 5, .05}, {.1, 0, .05}, .2);
  view.to_world = view.to_world * placed;
  RenderSettings s;
  s.spp = 256;
  const RenderedImage image = render(*b.build(), view, s);
  expect_exact(image, .5, 1e-6, s, {"20", "tile on a floor 1000 times as large"});
}

// Every triangle of a closed emissive cavity is present twice, and the radiance is still Le / (1 -
// rho). Equal triangles have equal error bounds, so a ray leaves both at once.
TEST(Coplanar, DoubledCavity) {
  for (const bool light_sampling : {true, false}) {
    SceneBuilderForTests b;
    MaterialDescription m = lambert(Rgb(.8f));
    m.emission = Rgb(.2f);
    const int material = b.add_material(m);
    const MeshDescription ball = SceneBuilderForTests::sphere(1.0f, 16, material, true);
    b.place(b.add_mesh(ball), oblique(.3, {1, 2, 3}));
    b.place(b.add_mesh(ball), oblique(.3, {1, 2, 3}));
    RenderSettings s;
    s.spp = 64;
    s.max_depth = 1000;
    s.light_samples = light_sampling ? 1 : 0;
    const auto scene = b.build();
    expect_exact(render(*scene, perspective({1, 2, 3}, {1.2, 2.1, 2}, 90), s), 1.0, 1e-5, s,
                 {"20", light_sampling ? "doubled cavity" : "doubled cavity, BSDF sampling"});
  }
}

// Three copies of a reflecting floor in the same place, in a furnace, reflect like one floor.
TEST(Coplanar, DoubledFloorIsOneFloor) {
  SceneBuilderForTests b;
  const int material = b.add_material(lambert(Rgb(.5f)));
  for (int i = 0; i < 3; ++i) {
    b.place(b.add_mesh(square_mesh(50, .3f, true, material)), oblique(.9, {7, 1, 2}));
  }
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  CameraDescription view = orthographic({3, 5, 4}, {1, .3, 2}, 2);
  view.to_world = view.to_world * oblique(.9, {7, 1, 2});
  RenderSettings s;
  s.spp = 256;
  expect_exact(render(*scene, view, s), .5, 1e-6, s, {"20", "tripled floor in a furnace"});
}

}  // namespace
}  // namespace emberline
