// Case 29: from every angle and distance the floor under a rectangular lamp shows the irradiance of
// case 6, without acne. Other tests put cameras in unusual places.
#include "closed_form.h"
#include "renderer/engine/render_sink.h"
#include "renderer/engine/render_worker.h"
#include "renderer/film/film.h"
#include "support/closed_forms.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings camera_settings() {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 1024;
  s.max_depth = 1;
  return s;
}

// Returns the radiance E / pi at the origin of a floor of 2 km, under a one-sided lamp that faces
// down.
double floor_radiance() {
  return polygon_irradiance({{-.5, 1.2, -.3}, {.9, 1.2, -.3}, {.9, 1.2, .7}, {-.5, 1.2, .7}},
                            Vec3d(0.0), Vec3d(0, 1, 0)) /
         kPiD;
}
std::unique_ptr<Scene> square_over_floor() {
  SceneBuilderForTests b;
  b.add_quad({-.5f, 1.2f, -.3f}, {.9f, 1.2f, -.3f}, {.9f, 1.2f, .7f}, {-.5f, 1.2f, .7f},
             b.add_material(emitter(Rgb(1.0f))));
  b.add_floor(1000, 0, b.add_material(lambert(Rgb(1.0f))));
  return b.build();
}

// Returns the largest relative error of the mean over a spot of radius r around the origin. There
// the relative second derivatives of E are below 1 / h^2 = .7, where h is the lamp's height. The
// first-order terms cancel in the mean, so the error is below .7 r^2 / 2.
double spot(double radius) { return std::max(1e-5, .35 * square(radius)); }

CameraDescription at_angle(bool perspective_camera, double degrees, double distance,
                           double radius) {
  const double a = degrees * kPiD / 180;
  // The direction lies in no symmetry plane of the floor's triangles.
  const Vec3d d(std::sin(a) * .8, std::cos(a), std::sin(a) * .6);
  return perspective_camera
             ? perspective(d * distance, Vec3d(0.0), 360 / kPiD * std::atan(radius / distance))
             : orthographic(d * distance, Vec3d(0.0), radius);
}

TEST(Cameras, GrazingAndFar) {
  const auto scene = square_over_floor();
  const RenderSettings s = camera_settings();
  const double exact = floor_radiance();
  for (const bool is_perspective : {true, false}) {
    const std::string kind = is_perspective ? "perspective" : "orthographic";
    // The spot's radius is 1e-5 across the view, which is 1e-5 / cos(89.9 degrees) = 6e-3 along the
    // floor.
    expect_exact(render(*scene, at_angle(is_perspective, 89.9, 1, 1e-5), s), exact, spot(6e-3), s,
                 {"29", kind + " at 89.9 degrees"});
    // These views are from 1e-3 and from 1e3 away, a ratio of 1e6. At 1e3, rounding to float moves
    // the hit point by up to 6e-5, but the point stays on the floor.
    expect_exact(render(*scene, at_angle(is_perspective, 30, 1e-3, 1e-5), s), exact, 1e-5, s,
                 {"29", kind + " 1e-3 away"});
    expect_exact(render(*scene, at_angle(is_perspective, 70, 1e3, 1e-3), s), exact, spot(3e-3), s,
                 {"29", kind + " 1e3 away"});
    expect_exact(render(*scene, at_angle(is_perspective, 89.9, 1e3, 1e-5), s), exact, spot(1e-1), s,
                 {"29", kind + " 1e3 away at 89.9 degrees"});
  }
}

// At 179 degrees the frame is 229 wide at a distance of 1, so each of its 1e5 pixels is 2.3e-3
// wide. A film coordinate near 5e4 is a float with steps of 1/256 pixel, which does not matter
// here.
TEST(Cameras, WideAngle) {
  const auto scene = square_over_floor();
  RenderSettings s = camera_settings();
  s.width = s.height = 100'000;
  s.crop = {49'996, 49'996, 50'004, 50'004};
  expect_exact(render(*scene, perspective({.1, .8, .1}, {0, 0, 0}, 179), s), floor_radiance(),
               spot(1.5e-2), s, {"29", "179 degrees, 1e5 x 1e5 pixels"});
  // This is a narrow view of 1e-4 degrees.
  expect_exact(render(*scene, perspective({.1, .8, .1}, {0, 0, 0}, 1e-4), camera_settings()),
               floor_radiance(), 1e-5, camera_settings(), {"29", "1e-4 degrees"});
}

// An edge crosses the last pixel of a frame that is 1e5 pixels wide. There the film coordinate is a
// float with 128 steps per pixel. The direction itself is rounded by 6e-8, which is 1/170 of a
// pixel of 1e-5. So the edge is off by 1/128 + 1/170 of a pixel at most.
TEST(Cameras, LastPixelOfAWideFrame) {
  SceneBuilderForTests b;
  const double width = 100'000, pixel = 2 / width;  // the frame spans x in [-1, 1]
  const auto edge = float(1 - .7 * pixel);
  b.add_quad({edge, -1, 0}, {2, -1, 0}, {2, 1, 0}, {edge, 1, 0},
             b.add_material(emitter(Rgb(1.0f))));
  RenderSettings s = camera_settings();
  s.width = 100'000;
  s.height = 1;
  s.crop = {99'999, 0, 100'000, 1};
  s.spp = 16384;
  // The exact coverage follows from the edge as rounded to float.
  const double exact = (1 - double(edge)) / pixel;
  const RenderedImage image = render(*b.build(), orthographic({0, 0, 1}, {0, 0, 0}, 1 / width), s);
  expect_case({"E24", "coverage of pixel 99999 of 100000"},
              {exact, image.mean, 0, 1. / 128 + 1. / 170}, replay(s));
}

// Tests a frame of one pixel, and tests that samples from 2^31 on are as good as the first ones.
TEST(Cameras, OnePixelAndLateSamples) {
  const auto scene = square_over_floor();
  RenderSettings s = camera_settings();
  s.width = s.height = 1;
  s.spp = 65536;
  // One pixel has no spread from which to estimate an error. The error comes from 1024 pixels with
  // 64 samples each.
  RenderSettings many = s;
  many.width = many.height = 32;
  many.spp = 64;
  const CameraDescription view = orthographic({.1, .8, .1}, {0, 0, 0}, 1e-4);
  const double error = render(*scene, view, many).standard_error;  // for the same number of samples
  const double exact = floor_radiance();
  expect_case({"E25", "frame of one pixel"},
              {exact, render(*scene, view, s).mean, error, 1e-5 * exact}, replay(s));

  const Camera camera(view, 32, 32, scene->origin(), scene->scale());
  const RenderPlan plan = plan_of(many);
  const Frame frame = plan.frame(*scene, camera);
  FilmTile tile{AovSet{}};
  tile.reset(plan.crop);
  RenderWorker worker(frame);
  struct NullSink final : RenderSink {
    void tile_finished(const FilmTile&) override {}
  } null_sink;
  std::vector<PixelWork> list;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) list.push_back({x, y, 1u << 31, 64});
  }
  ASSERT_TRUE(worker.render(list, tile, null_sink, {}));
  double sum = 0;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) sum += double(tile.mean(x, y).x) / 1024;
  }
  expect_case({"E25", "samples 2^31 to 2^31 + 63"}, {exact, sum, error, 1e-5 * exact},
              "32 x 32, 64 samples from 2^31, seed 1");
}

// Cameras lie on a wall, an edge and a vertex of a uniformly bright cavity. One more lies in the
// plane of a floor and looks along it. All of them see 1, and no NaN.
TEST(Cameras, OnASurface) {
  SceneBuilderForTests b;
  MaterialDescription m = lambert(Rgb(.8f));
  m.emission = Rgb(.2f);
  const MeshDescription ball = SceneBuilderForTests::sphere(1, 8, b.add_material(m), true);
  b.place(b.add_mesh(ball));
  b.add_floor(.2f, 0, b.add_material(m));
  const auto scene = b.build();
  const auto& t = ball.triangles[70];
  const Vec3d p0(ball.positions[t[0]]), p1(ball.positions[t[1]]), p2(ball.positions[t[2]]);
  const std::pair<const char*, Vec3d> places[] = {{"a face", (p0 + p1 + p2) / 3.0},
                                                  {"an edge", (p0 + p1) / 2.0},
                                                  {"a vertex", p0},
                                                  {"the plane of a floor", {.7, 0, .1}}};
  for (const auto& [name, at] : places) {
    RenderSettings s = camera_settings();
    s.spp = long_or_short(64u, 16u);
    s.width = s.height = 16;
    s.max_depth = 1000;
    // The floor's plane passes between two rows of pixels in even frames, and through pixels'
    // centres in odd ones.
    for (const int width : {16, 15}) {
      s.width = s.height = width;
      const RenderedImage image = render(*scene, perspective(at, {0, 0, 0}, 100), s);
      expect_exact(image, 1.0, 1e-5, s,
                   {"E26", std::string("camera on ") + name + ", " + std::to_string(width)});
    }
  }
}

}  // namespace
}  // namespace emberline
