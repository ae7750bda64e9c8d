// Cameras inside solids (E54): Beer's law from the camera to the first surface.
#include "renderer/scene/camera_solids.h"

#include "closed_form.h"
#include "renderer/core/log.h"
#include "support/glass_scenes.h"
#include "support/moving_scenes.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// Returns a medium of index 1 that transmits half of the light per unit of length.
MaterialDescription half_per_unit() {
  MaterialDescription m = glass(1, 0);
  m.attenuation_color = Rgb(.5f);
  m.attenuation_distance = 1;
  return m;
}

RenderSettings settings() {
  RenderSettings s;
  s.width = s.height = 8;
  s.max_depth = 8;
  return s;
}

// Returns a wall of radiance 1 at z = 0 that stands inside a box. The box reaches from z = -1 to z
// = `depth`, and lacks a triangle unless it is `closed`.
SceneBuilderForTests wall_behind(float depth, bool closed = true) {
  SceneBuilderForTests b;
  const int solid = b.add_material(half_per_unit());
  MeshDescription box = SceneBuilderForTests::box({-20, -20, -1}, {20, 20, depth}, solid);
  if (!closed) box.triangles.pop_back();
  b.place(b.add_mesh(box));
  const int lamp = b.add_material(emitter(Rgb(1.0f)));
  b.add_quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, lamp);
  b.set_environment(Rgb(0.0f));
  return b;
}

const Vec3d kEye(.1, .2, 2), kTarget(.1, .2, 0);

TEST(CameraSolids, BeersLawFromTheCamera) {
  const RenderSettings s = settings();
  expect_exact(render(*wall_behind(5).build(), perspective(kEye, kTarget, 1e-3), s), .25, 1e-5, s,
               {"E54", "from inside a solid"});
  expect_exact(render(*wall_behind(1).build(), perspective(kEye, kTarget, 1e-3), s), .5, 1e-5, s,
               {"E54", "from in front of a solid"});
  expect_exact(render(*wall_behind(5).build(), orthographic(kEye, kTarget, 1e-3), s), .25, 1e-5, s,
               {"E54", "from inside a solid, orthographic"});
}

TEST(CameraSolids, InsideOfTwo) {
  SceneBuilderForTests b = wall_behind(5);
  // A clear solid surrounds the camera and reaches half of the way to the wall.
  b.add_box({-1, -1, 1}, {1, 1, 3}, b.add_material(glass(1, 0)));
  const RenderSettings s = settings();
  expect_exact(render(*b.build(), perspective(kEye, kTarget, 1e-3), s), .5, 1e-5, s,
               {"E54", "from inside a clear solid in a dark one"});
}

TEST(CameraSolids, AtAnyScale) {
  for (const double scale : {1e-6, 1e6}) {
    SceneBuilderForTests b = wall_behind(5);
    b.description.materials[0].attenuation_distance = float(scale);
    for (MeshDescription& mesh : b.description.meshes) {
      for (Vec3f& p : mesh.positions) p *= float(scale);
    }
    const RenderSettings s = settings();
    expect_exact(render(*b.build(), perspective(kEye * scale, kTarget * scale, 1e-3), s), .25, 1e-5,
                 s, {"E54", "from inside a solid, scaled by " + std::to_string(scale)});
  }
}

// An instance of a closed mesh stays closed when it is mirrored and rotated.
TEST(CameraSolids, InsideOfInstances) {
  SceneBuilderForTests b;
  const int mesh =
      b.add_mesh(SceneBuilderForTests::sphere(30, 12, b.add_material(half_per_unit())));
  b.place(mesh, scaling(-1, 1.5, 1) * turned(.3));
  b.place(mesh, translation(500, 0, 0));
  b.add_quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, b.add_material(emitter(Rgb(1.0f))));
  b.set_environment(Rgb(0.0f));
  const RenderSettings s = settings();
  expect_exact(render(*b.build(), perspective(kEye, kTarget, 1e-3), s), .25, 1e-5, s,
               {"E54", "from inside a mirrored instance"});
}

// Half of the rays of an orthographic frame start inside the solid, and so do half of the rays of a
// lens.
TEST(CameraSolids, EachRayBeginsWhereItIs) {
  SceneBuilderForTests b;
  b.add_box({-20, -20, -1}, {0, 20, 5}, b.add_material(half_per_unit()));
  b.add_quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, b.add_material(emitter(Rgb(1.0f))));
  b.set_environment(Rgb(0.0f));
  const auto scene = b.build();
  RenderSettings s = settings();
  expect_exact(render(*scene, orthographic({0, .2, 2}, {0, .2, 0}, 1), s), (.25 + 1) / 2, 1e-5, s,
               {"E54", "orthographic, half of it inside"});

  CameraDescription lens = perspective({0, .2, 2}, {0, .2, 0}, 1e-3);
  lens.lens_radius = 1e-3;
  lens.focus_distance = 2;
  s.spp = 1024;
  const RenderedImage image = render(*scene, lens, s);
  // The solid absorbs light along the part at x < 0 of each line from the lens to the wall. The
  // midpoint rule integrates over the frame and over the lens, where it weights positions by the
  // disc's chords.
  constexpr int kSteps = 2000;
  const double half = 2 * std::tan(.5e-3 * kPiD / 180);
  double sum = 0, weights = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double across = (i + .5) / kSteps * 2 - 1, from = 1e-3 * across;
    for (int k = 0; k < kSteps; ++k) {
      const double to = half * ((k + .5) / kSteps * 2 - 1);
      const double inside = (std::max(0., -from) + std::max(0., -to)) / (std::abs(from - to));
      const double share = from < 0 && to < 0 ? 1 : from >= 0 && to >= 0 ? 0 : inside;
      sum += std::sqrt(1 - across * across) * std::pow(.5, 2 * share);
      weights += std::sqrt(1 - across * across);
    }
  }
  expect_case({"E54", "half of the lens inside"},
              {sum / weights, image.mean, image.standard_error, 1e-4}, replay(s));
}

TEST(CameraSolids, InMotion) {
  RenderSettings s = settings();
  s.spp = 1024;
  s.shutter = Shutter{0, 1};
  // The camera moves from 1 outside the solid to 3 inside it, so it enters the solid after a
  // quarter of the time.
  CameraDescription camera = perspective({-1, .2, 2}, {-1, .2, 0}, 1e-3);
  camera.motion = {camera.to_world};
  camera.motion[0][3][0] += 4;
  SceneBuilderForTests b;
  b.add_box({0, -20, -1}, {20, 20, 5}, b.add_material(half_per_unit()));
  b.add_quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, b.add_material(emitter(Rgb(1.0f))));
  b.set_environment(Rgb(0.0f));
  const RenderedImage moving = render(*b.build(), camera, s);
  expect_case({"E54", "the camera goes into a solid"},
              {.25 + .75 * .25, moving.mean, moving.standard_error, 1e-5}, replay(s));

  // Here the solid moves over the camera.
  b.description.instances[0].motion = {translation(-3, 0, 0)};
  const RenderedImage covered =
      render(*b.build(), perspective({-1.5, .2, 2}, {-1.5, .2, 0}, 1e-3), s);
  expect_case({"E54", "a solid goes over the camera"},
              {.5 + .5 * .25, covered.mean, covered.standard_error, 1e-5}, replay(s));
}

// A lamp, a floor and the camera are in the same body of water.
TEST(CameraSolids, UnderWater) {
  SceneBuilderForTests b;
  MaterialDescription water = half_per_unit();
  water.ior = 1.33f;
  b.add_box({-9, -1, -9}, {9, 9, 9}, b.add_material(water));
  b.add_floor(5, 0, b.add_material(lambert(Rgb(1.0f))));
  b.add_point_light({0, 2, 0}, Rgb(4.0f));
  RenderSettings s = settings();
  s.max_depth = 1;
  expect_exact(render(*b.build(), orthographic({.001, 1, .002}, {.001, 0, .002}, 1e-3), s),
               4 / (kPiD * 4) * .125, 1e-5, s, {"E54", "camera, lamp and floor under water"});
}

// A mesh that lacks a face is no solid for the camera, and a warning says so.
TEST(CameraSolids, AnOpenMeshIsNone) {
  std::vector<std::string> warnings;
  set_log_sink([&](LogKind, std::string_view message) { warnings.emplace_back(message); });
  const RenderSettings s = settings();
  const RenderedImage image =
      render(*wall_behind(5, false).build(), perspective(kEye, kTarget, 1e-3), s);
  set_log_sink(nullptr);
  EXPECT_NEAR(image.mean, 1, 1e-6);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("'box'"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find("not closed"), std::string::npos) << warnings[0];
}

struct Part {
  int material;
  size_t faces;
};

// Places a mesh as several primitives of one node. Each part takes the mesh's next `faces`
// triangles.
void place_in_parts(const MeshDescription& whole, const std::vector<Part>& parts,
                    SceneBuilderForTests& b, const Mat44d& to_world = Mat44d()) {
  auto face = whole.triangles.begin();
  for (const Part& part : parts) {
    MeshDescription mesh = whole;
    mesh.triangles.assign(face, face + std::ptrdiff_t(part.faces));
    mesh.material = part.material;
    b.place(b.add_mesh(mesh), to_world);
    b.description.instances.back().node = 0;
    face += std::ptrdiff_t(part.faces);
  }
  ASSERT_EQ(face, whole.triangles.end());
}

void add_wall(SceneBuilderForTests& b) {
  b.add_quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, b.add_material(emitter(Rgb(1.0f))));
  b.set_environment(Rgb(0.0f));
}

struct ImageAndWarnings {
  RenderedImage image;
  std::vector<std::string> warnings;
};

ImageAndWarnings look(const SceneBuilderForTests& b, const CameraDescription& camera,
                      const RenderSettings& s) {
  ImageAndWarnings result;
  set_log_sink([&](LogKind, std::string_view message) { result.warnings.emplace_back(message); });
  result.image = render(*b.build(), camera, s);
  set_log_sink(nullptr);
  return result;
}

void expect_same(const ImageAndWarnings& split, const ImageAndWarnings& whole,
                 const std::string& what) {
  SCOPED_TRACE(what);
  EXPECT_EQ(split.image.values, whole.image.values);
  EXPECT_EQ(split.warnings, whole.warnings);
}

// Primitives that are closed only together form one solid. Here they are two halves of a sphere, or
// six sides of a box. Their surfaces may differ if their interiors agree.
TEST(CameraSolids, PartsThatAreClosedTogether) {
  for (const MeshDescription& mesh : {SceneBuilderForTests::sphere(30, 12, 0),
                                      SceneBuilderForTests::box({-9, -8, -7}, {9, 8, 7}, 0)}) {
    for (const bool is_tilted : {false, true}) {
      const Mat44d to_world = is_tilted ? turned(.3) * translation(.1, .2, .3) : Mat44d();
      SceneBuilderForTests whole, split;
      for (SceneBuilderForTests* b : {&whole, &split}) {
        b->add_material(half_per_unit());
        MaterialDescription frosted = half_per_unit();
        frosted.roughness = .5f;
        b->add_material(frosted);
      }
      whole.place(whole.add_mesh(mesh), to_world);
      const size_t faces = mesh.triangles.size(), half = faces / 2;
      const std::vector<Part> halves = {{0, half}, {0, faces - half}};
      const std::vector<Part> sides = {{0, 2}, {0, 2}, {1, 2}, {0, 2}, {0, 2}, {0, 2}};
      place_in_parts(mesh, faces == 12 ? sides : halves, split, to_world);
      // A smaller, clear solid inside displaces the medium.
      for (SceneBuilderForTests* b : {&whole, &split}) {
        add_wall(*b);
        b->add_box({-1, -1, .5f}, {1, 1, 1}, b->add_material(glass(1, 0)));
      }
      RenderSettings s = settings();
      const ImageAndWarnings seen = look(split, perspective(kEye, kTarget, 1e-3), s);
      expect_exact(seen.image, std::pow(.5, 1.5), 1e-5, s, {"E54", "from inside of parts"});
      EXPECT_TRUE(seen.warnings.empty()) << seen.warnings[0];
      expect_same(seen, look(whole, perspective(kEye, kTarget, 1e-3), s), "pinhole");
      CameraDescription lens = perspective({8.9, 0, 2}, {8.9, 0, 0}, 1e-3);
      lens.lens_radius = .5;
      lens.focus_distance = 2;
      expect_same(look(split, lens, s), look(whole, lens, s), "lens");
      // The parts move away from the camera.
      for (SceneBuilderForTests* b : {&whole, &split}) {
        for (InstanceDescription& placed : b->description.instances) {
          if (b->description.meshes[size_t(placed.mesh)].material > 1) continue;
          placed.motion = {to_world * translation(60, 0, 0)};
        }
      }
      s.shutter = Shutter{0, 1};
      const CameraDescription ahead = perspective(kEye, kTarget, 1e-3);
      const ImageAndWarnings left = look(split, ahead, s);
      expect_same(left, look(whole, ahead, s), "in motion");
      EXPECT_GT(left.image.mean, .5);
    }
  }
}

// An opaque label closes the surface of a bottle. Rays from inside end at the label's back.
TEST(CameraSolids, AnOpaquePartClosesASolid) {
  const MeshDescription box = SceneBuilderForTests::box({-9, -8, -7}, {9, 8, 7}, 0);
  const RenderSettings s = settings();
  for (const bool is_double_sided : {true, false}) {
    SceneBuilderForTests b;
    b.add_material(half_per_unit());
    MaterialDescription label = lambert(Rgb(.5f));
    label.double_sided = is_double_sided;
    b.add_material(label);
    place_in_parts(box, {{0, 10}, {1, 2}}, b);
    add_wall(b);
    // A single-sided label is a hole when seen from behind.
    const ImageAndWarnings seen = look(b, perspective(kEye, kTarget, 1e-3), s);
    EXPECT_NEAR(seen.image.mean, is_double_sided ? .25 : 1, 1e-5);
    EXPECT_EQ(seen.warnings.empty(), is_double_sided);
    for (const std::string& warning : seen.warnings) {
      EXPECT_NE(warning.find("not closed"), std::string::npos) << warning;
    }
  }
}

// Parts with different interiors stay open, since nothing says which interior fills the solid.
TEST(CameraSolids, PartsOfTwoMediaStayOpen) {
  SceneBuilderForTests b;
  b.add_material(half_per_unit());
  MaterialDescription other = half_per_unit();
  other.attenuation_distance = 2;
  b.add_material(other);
  place_in_parts(SceneBuilderForTests::box({-9, -8, -7}, {9, 8, 7}, 0), {{0, 10}, {1, 2}}, b);
  add_wall(b);
  const ImageAndWarnings seen = look(b, perspective(kEye, kTarget, 1e-3), settings());
  EXPECT_NEAR(seen.image.mean, 1, 1e-6);
  EXPECT_FALSE(seen.warnings.empty());
}

// From outside, a solid made of parts looks like a whole one, even if it overlaps a second solid
// and touches a third.
TEST(CameraSolids, PartsAreSeenAsOneSolid) {
  SceneBuilderForTests whole, split;
  const MeshDescription box = SceneBuilderForTests::box({-.6f, -.7f, -.5f}, {.7f, .6f, .5f}, 0);
  for (SceneBuilderForTests* b : {&whole, &split}) {
    b->add_material(glass(1.5f, 0));
    b->set_environment(upper_half());
  }
  whole.place(whole.add_mesh(box));
  place_in_parts(box, {{0, 3}, {0, 4}, {0, 5}}, split);
  for (SceneBuilderForTests* b : {&whole, &split}) {
    b->add_box({.3f, -.2f, -.3f}, {2, .3f, .4f}, b->add_material(glass(1.8f, 0)));
    b->add_box({-1, -.3f, -.2f}, {-.6f, .2f, .3f}, b->add_material(glass(1.33f, 0)));
  }
  RenderSettings s = settings();
  s.width = s.height = 32;
  s.spp = 64;
  s.max_depth = 64;
  const CameraDescription camera = perspective({.3, 1.2, 4}, {.02, .01, 0}, 40);
  expect_same(look(split, camera, s), look(whole, camera, s), "from outside");
}

// A camera outside all solids needs no look-up.
TEST(CameraSolids, NothingIsAskedOutsideOfSolids) {
  const auto scene = wall_behind(1).build();
  const CameraDescription view = perspective(kEye, kTarget, 10);
  const Camera camera(view, 8, 8, scene->origin(), scene->scale());
  EXPECT_EQ(CameraSolids::find(*scene, camera), nullptr);
}

}  // namespace
}  // namespace emberline
