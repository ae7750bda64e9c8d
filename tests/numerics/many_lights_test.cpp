// Case 31: sums of many samples. Case 32: one lamp among many, and one far away.
#include "closed_form.h"

#include "renderer/film/film.h"
#include "support/chi_square.h"
#include "support/closed_forms.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// Every sample is the float .1. The double sum has a relative rounding error of at most 2^25 2^-53.
TEST(LongSum, OfAConstant) {
  FilmTile tile{AovSet{}};
  tile.reset({0, 0, 1, 1});
  const SampleValue value{Rgb(.1f), 1.0f, {}, {}};
  for (uint32_t i = 0; i < 1u << 25; ++i) tile.add(0, 0, {value, 1.0f, int(i >> 3 & 1)});
  expect_case({"31", "mean of 2^25 samples of .1"}, {.1, double(tile.mean(0, 0).x), 0, 1e-7},
              "FilmTile, 2^25 samples");
}

// Radiances lie at both ends of float's range. The sum of 2^20 samples of 3e38 exceeds the range,
// but their mean does not. In the other pixel a million samples of 1e-36 follow one of 1e-30.
TEST(LongSum, AtTheEndsOfFloat) {
  FilmTile tile{AovSet::parse("variance")};
  tile.reset({0, 0, 2, 1});
  for (uint32_t i = 0; i < 1u << 20; ++i) {
    ASSERT_TRUE(tile.add(0, 0, {{Rgb(3e38f), 1.0f, {}, {}}, 1.0f, 0}));
    ASSERT_TRUE(tile.add(1, 0, {{Rgb(i == 0 ? 1e-30f : 1e-36f), 1.0f, {}, {}}, 1.0f, 0}));
  }
  expect_case({"E27", "mean of 2^20 samples of 3e38, over 3e38"},
              {1, double(tile.mean(0, 0).x) / double(3e38f), 0, 1e-6}, "FilmTile");
  expect_case({"E27", "mean of 1e-30 and 2^20 of 1e-36, over 1e-36"},
              {1 + 1e6 * 0x1p-20, double(tile.mean(1, 0).x) / 1e-36, 0, 1e-6}, "FilmTile");
  std::vector<float> out;
  tile.resolve(out);
  double not_finite = 0;
  for (const float v : out) not_finite += !std::isfinite(v);
  expect_case({"E27", "channels of it that are not finite"}, {0, not_finite, 0, 0}, "FilmTile");
}

RenderSettings lights_settings() {
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = 1024;
  s.max_depth = 1;
  return s;
}

void add_lamp(MeshDescription& mesh, const Vec3f& at, float size) {
  const auto first = uint32_t(mesh.positions.size());
  for (const float x : {0.0f, size}) mesh.positions.push_back(at + Vec3f(x, 0, 0));
  for (const float x : {size, 0.0f}) mesh.positions.push_back(at + Vec3f(x, 0, size));
  mesh.triangles.push_back({first, first + 1, first + 2});  // facing down
  mesh.triangles.push_back({first, first + 2, first + 3});
}

double lamp_radiance(const Vec3f& at, float size) {
  const Vec3d p(at), x(double(size), 0, 0), z(0, 0, double(size));
  return polygon_irradiance({p, p + x, p + x + z, p + z}, Vec3d(0.0), Vec3d(0, 1, 0)) / kPiD;
}

// Case 32: all but one of ten thousand lamps are above a black ceiling.
TEST(ManyLamps, OneIsVisible) {
  SceneBuilderForTests b;
  MeshDescription lamps, plates;
  lamps.name = "lamps";
  plates.name = "plates";
  lamps.material = b.add_material(emitter(Rgb(50.0f)));
  plates.material = b.add_material(lambert(Rgb(0.0f)));
  add_lamp(plates, Vec3f(-60, 1.9f, -60), 120);
  double exact = 0;
  for (uint32_t i = 0; i < 10'000; ++i) {
    TestRandom random(32, i);
    Vec3f at(float(i % 100) - 50 + .6f * random.next(), 2 + random.next(),
             float(i / 100) - 50 + .6f * random.next());
    if (i == 5249) {  // at about (-.7, 1.8, 2.3)
      at.y = 1.8f;
      exact = 50 * lamp_radiance(at, .2f);
    }
    add_lamp(lamps, at, .2f);
  }
  b.place(b.add_mesh(lamps));
  b.place(b.add_mesh(plates));
  b.add_floor(100, 0, b.add_material(lambert(Rgb(1.0f))));
  const auto scene = b.build();
  for (const bool light_sampling : {true, false}) {
    RenderSettings s = lights_settings();
    s.light_samples = light_sampling ? 1 : 0;
    s.spp = light_sampling ? 4096 : 16384;
    expect_exact(render(*scene, orthographic({0, .5, 0}, {0, 0, 0}, 1e-4), s), exact, 1e-5, s,
                 {"32", light_sampling ? "10^4 lamps, one visible"
                                       : "10^4 lamps, one visible, BSDF sampling"});
  }
}

// Two lamps of the same power are 1 and 1e4 away. The receiver sees both, or only the far one when
// a plate hides the near one.
TEST(ManyLamps, NearAndFar) {
  for (const bool near_hidden : {false, true}) {
    SceneBuilderForTests b;
    MeshDescription lamps;
    lamps.name = "lamps";
    lamps.material = b.add_material(emitter(Rgb(100.0f)));
    const Vec3f near(.3f, 1, .2f), far(-6e3f, 8e3f, .2f);
    add_lamp(lamps, near, .5f);
    add_lamp(lamps, far, .5f);
    b.place(b.add_mesh(lamps));
    if (near_hidden) {
      MaterialDescription black = lambert(Rgb(0.0f));
      black.double_sided = true;
      MeshDescription plate;
      plate.name = "plate";
      plate.material = b.add_material(black);
      add_lamp(plate, near - Vec3f(.25f, .1f, .25f), 1);
      b.place(b.add_mesh(plate));
    }
    b.add_floor(10, 0, b.add_material(lambert(Rgb(1.0f))));
    RenderSettings s = lights_settings();
    // The tolerance is 1e-5. That of the far lamp covers the rounding of its corners: a side of .5
    // at 8e3 is known to 1e-3.
    const double exact =
        (near_hidden ? 0 : 100 * lamp_radiance(near, .5f)) + 100 * lamp_radiance(far, .5f);
    expect_exact(
        render(*b.build(), orthographic({0, .05, 0}, {0, 0, 0}, 1e-5), s), exact,
        near_hidden ? 2e-3 : 1e-5, s,
        {"32", near_hidden ? "the farther of two lamps at 1 : 1e4" : "two lamps at 1 : 1e4"});
  }
}

}  // namespace
}  // namespace emberline
