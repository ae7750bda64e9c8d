// Changes other than movement while the shutter is open (E48): lights that blink, fade and change
// colour, zoom lenses, and objects that appear and disappear.
#include "lamp_over_floor.h"

#include "renderer/core/moments.h"
#include "support/chi_square.h"
#include "support/moving_scenes.h"

namespace emberline {
namespace {

using namespace test;

using Share = std::shared_ptr<const TimeCurve<Rgb>>;

constexpr const char* kCase = "E48";

// Returns a share that is 1 from `from` to `to`, and 0 otherwise.
Share on(float from, float to) {
  return over_time<Rgb>({from, from, to, to}, {Rgb(0.0f), Rgb(1.0f), Rgb(1.0f), Rgb(0.0f)});
}

// ---- point lights ----------------------------------------------------------------------------

// Returns the irradiance at the point that expect_irradiance_at measures, from 1 candela at (.1,
// .8, 0).
double unit_irradiance() {
  const Vec3d to = Vec3d(.1, .8, 0) - Vec3d(.3, 0, .1);
  return to.y / std::pow(to.length(), 3);
}

void expect_point_light(const std::string& what, const Share& share, double exact,
                        PunctualType type = PunctualType::kPoint) {
  SceneBuilderForTests b = white_floor();
  b.add_point_light({.1, .8, 0}, Rgb(1.0f));
  PunctualLightDescription& light = b.description.lights[0];
  light.share = share;
  light.type = type;
  if (type == PunctualType::kDirectional) light.to_world = look_at_matrix({0, 1, 0}, {0, 0, 0});
  const double steady = type == PunctualType::kDirectional ? 1 : unit_irradiance();
  expect_irradiance_at(kCase, b, exact * steady, 1e-5, what);
}

TEST(Blink, PointLights) {
  expect_point_light("point light, on from .3 to .8", on(.3f, .8f), .5);
  expect_point_light("point light, on for a thousandth", on(.41f, .411f), .001);
  expect_point_light("sun, on from .3 to .8", on(.3f, .8f), .5, PunctualType::kDirectional);
  expect_point_light("point light that fades", over_time<Rgb>({0, 1}, {Rgb(1.0f), Rgb(0.0f)}), .5);
  expect_point_light("point light that fades early",
                     over_time<Rgb>({.1f, .3f}, {Rgb(1.0f), Rgb(.25f)}), .1 + .2 * .625 + .7 * .25);
  // The light flashes 250,000 times, each time for a quarter of the period.
  constexpr int kFlashes = 250'000;
  std::vector<float> times;
  std::vector<Rgb> values;
  for (int i = 0; i < kFlashes; ++i) {
    for (const float value : {1.0f, 0.0f}) {
      const double begin = (i + (value > 0 ? 0 : .25)) / kFlashes;
      times.insert(times.end(), 2, float(begin));
      values.insert(values.end(), {Rgb(1 - value), Rgb(value)});
    }
  }
  // The tolerance is 1e-2, since floats near 1 are a sixtieth of a period apart and both ends of a
  // flash are rounded.
  SceneBuilderForTests b = white_floor();
  b.add_point_light({.1, .8, 0}, Rgb(1.0f));
  b.description.lights[0].share = over_time(times, values);
  expect_irradiance_at(kCase, b, .25 * unit_irradiance(), 1e-2,
                       "point light that flashes 250000 times");
}

TEST(Blink, ColoursOfAPointLight) {
  SceneBuilderForTests b = white_floor();
  b.add_point_light({.1, .8, 0}, {2, 1, 4});
  // The light is red until .2. Then it changes linearly to half green and full blue.
  b.description.lights[0].share =
      over_time<Rgb>({.2f, 1}, {Rgb(1.0f, 0.0f, 0.0f), Rgb(0.0f, .5f, 1.0f)});
  const double exact[] = {2 * (.2 + .8 * .5), .8 * .25, 4 * .8 * .5};
  RenderSettings s = direct_light_settings();
  s.seed = seed_of({kCase, "colours"});
  const RenderedImage image = render(*b.build(), orthographic({.3, .5, .1}, {.3, 0, .1}, 1e-4), s);
  for (int c = 0; c < 3; ++c) {
    Moments values;
    for (int i = 0; i < 64; ++i) values.add(double(image.rgb(i % 8, i / 8)[c]) * kPiD);
    const double e = exact[c] * unit_irradiance();
    expect_case({kCase, std::string("point light from red to teal, ") + "RGB"[c]},
                {e, values.mean(), values.standard_error(), 1e-5 * e}, replay(s));
  }
}

// ---- emitters --------------------------------------------------------------------------------

// Tests the lamp of lamp_over_floor.h, which is lit for part of the time. `exact` is the mean of
// `share`.
void expect_lamp(const std::string& what, const Share& share, double exact) {
  SceneBuilderForTests b = white_floor();
  MaterialDescription lamp = emitter(Rgb(50.0f));
  lamp.emission_scale = share;
  add_lamp(b, lamp);
  const double steady = lamp_irradiance([](double) { return 1.0; });
  expect_irradiance_at(kCase, b, exact * steady, 2e-5, what);
  // Here the camera sees the lamp from below.
  const CaseName name{kCase, what + ", seen"};
  RenderSettings s = direct_light_settings(256);
  s.seed = seed_of(name);
  const RenderedImage image = render(*b.build(), orthographic({1.3, 1, .1}, {1.3, 2, .1}, .05), s);
  expect_exact(image, exact * 50, 1e-6, s, name);
}

TEST(Blink, Lamps) {
  expect_lamp("lamp, on from .2 to .5", on(.2f, .5f), .3);
  expect_lamp("lamp that fades", over_time<Rgb>({0, .5f}, {Rgb(1.0f), Rgb(0.0f)}), .25);
}

// opening_spot returns a spotlight that points down while its cone opens. spot_irradiance returns
// its irradiance, at intensity 1, on a floor at the point from which the light lies at `to_light`.
PunctualLightDescription opening_spot(const Vec3d& at, float intensity) {
  PunctualLightDescription light;
  light.type = PunctualType::kSpot;
  light.to_world = look_at_matrix(at, at - Vec3d(0, 1, 0), {1, 0, 0});
  light.cones = over_time<Vec2f>({0, .8f}, {{.05f, .1f}, {.2f, .9f}});
  light.inner_cone = .2f;
  light.outer_cone = .9f;
  light.intensity = Rgb(intensity);
  return light;
}

double spot_irradiance(const Vec3d& to_light) {
  const double cosine = to_light.y / to_light.length();
  double sum = 0;
  constexpr int kTimes = 20000;
  for (int i = 0; i < kTimes; ++i) {
    const double share = std::min(1.0, (i + .5) / kTimes / .8);
    const double inner = std::cos(.05 + .15 * share), outer = std::cos(.1 + .8 * share);
    const double scale = 1 / std::max(.001, inner - outer);
    sum += square(std::clamp((cosine - outer) * scale, 0.0, 1.0)) / kTimes;
  }
  return sum * cosine / to_light.length2();
}

TEST(Blink, ASpotWhoseConeOpens) {
  SceneBuilderForTests b = white_floor();
  b.description.lights.push_back(opening_spot({.1, .8, 0}, 1));
  expect_irradiance_at(kCase, b, spot_irradiance(Vec3d(.1, .8, 0) - Vec3d(.3, 0, .1)), 2e-5,
                       "spot whose cone opens");
}

// Lamps blink or appear at different times, and the cones of spotlights open. The light BVH selects
// each light by its maximum brightness and its widest cone.
TEST(Blink, ManyLamps) {
  constexpr int kLamps = 48;
  SceneBuilderForTests b = white_floor();
  double exact = 0;
  const Vec3d point(.3, 0, .1);
  for (int i = 0; i < kLamps; ++i) {
    const Vec3d at(-1.4 + .4 * (i % 8), .8 + .05 * (i % 5), -1 + .4 * double(i / 8));
    const float begin = float(i % 16) / 16, end = begin + float(1 + i % 3) / 16;
    const float radiance = float(1 + i % 7);
    const double share = double(std::min(1.0f, end) - begin);
    const Vec3d to = at - point;
    if (i % 4 == 0) {
      b.add_point_light(at, Rgb(radiance));
      b.description.lights.back().share = on(begin, end);
      exact += share * double(radiance) * to.y / std::pow(to.length(), 3);
    } else if (i % 4 == 1) {
      b.description.lights.push_back(opening_spot(at, radiance));
      exact += double(radiance) * spot_irradiance(to);
    } else {
      MaterialDescription lamp = emitter(Rgb(radiance));
      if (i % 4 == 2) lamp.emission_scale = on(begin, end);
      const Vec3f p(at), x(.1f, 0, 0), z(0, 0, .2f);
      b.add_quad(p, p + x, p + x + z, p + z, b.add_material(lamp));
      if (i % 4 == 3) b.description.instances.back().visibility = visible_from(false, {begin, end});
      const double e = polygon_irradiance({Vec3d(p), Vec3d(p + x), Vec3d(p + x + z), Vec3d(p + z)},
                                          point, Vec3d(0, 1, 0));
      exact += share * double(radiance) * std::abs(e);
    }
  }
  expect_irradiance_at(kCase, b, exact, 2e-5, "48 lamps that blink in turn");
  b.description.lights.clear();
  const auto scene = b.build();
  ASSERT_NE(scene->lights().describe().find("light BVH"), std::string::npos);
  // Paths of two scattering events give the same mean with and without light samples.
  const auto view = orthographic({.3, .5, .1}, {.3, 0, .1}, 1e-4);
  MeasuredMean found[2];
  RenderSettings s = direct_light_settings(4096);
  s.max_depth = 2;
  for (const bool light_sampling : {false, true}) {
    s.light_samples = light_sampling ? 1 : 0;
    s.seed = seed_of({kCase, "two estimators"}) + uint32_t(light_sampling);
    found[light_sampling] = mean_of(*scene, view, s);
  }
  expect_case({kCase, "24 lamps that blink in turn, BSDF sampling alone against both"},
              {found[1].mean, found[0].mean,
               std::hypot(found[0].standard_error, found[1].standard_error), 0},
              replay(s));
}

// ---- appearing objects -----------------------------------------------------------------------

// Expects the mean radiance `exact` in a narrow view of the origin.
void expect_seen(const std::string& what, const SceneBuilderForTests& b, double exact,
                 double tolerance = 1e-6) {
  const CaseName name{kCase, what};
  RenderSettings s = direct_light_settings(1024);
  s.seed = seed_of(name);
  expect_case(
      name,
      compared(render(*b.build(), orthographic({0, 0, 5}, {0, 0, 0}, .1), s), exact, tolerance),
      replay(s));
}

MeshDescription square_of(int material) {
  MeshDescription mesh;
  mesh.name = "square";
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = material;
  return mesh;
}

TEST(Blink, ThingsThatAppear) {
  SceneBuilderForTests b;
  const int mesh = b.add_mesh(square_of(b.add_material(emitter(Rgb(1.0f)))));
  b.place(mesh);
  b.description.instances[0].visibility = visible_from(false, {.25f, .55f});
  expect_seen("square, there for .3", b, .3);
  // A second instance of the mesh, far away and always visible, keeps the first one from being
  // baked.
  b.place(mesh, translation(9, 0, 0));
  expect_seen("instance of a square, there for .3", b, .3);
  b.description.instances[0].motion = {translation(.3, 0, 0)};
  expect_seen("moving instance of a square, there for .3", b, .3);
  std::vector<float> changes;
  constexpr int kTimes = 50'000;
  for (int i = 0; i < kTimes; ++i) {
    changes.push_back(float((i + .3) / kTimes));
    changes.push_back(float((i + 1.0) / kTimes));
  }
  b.description.instances[0].visibility = visible_from(true, changes);
  // The tolerance is 5e-3, since floats near 1 are a 300th of a period apart.
  expect_seen("square that comes and goes 50000 times", b, .3, 5e-3 * .3);
}

TEST(Blink, WhatHasAlphaAppears) {
  SceneBuilderForTests b;
  MaterialDescription card = emitter(Rgb(1.0f));
  card.alpha_mode = AlphaMode::kBlend;
  card.alpha = .5f;
  b.place(b.add_mesh(square_of(b.add_material(card))));
  b.description.instances[0].visibility = visible_from(true, {.4f});
  expect_seen("square of alpha .5, there for .4", b, .2);
}

// A lamp is flush with its wall. When one of the two disappears, the camera sees the other.
TEST(Blink, AFlushLampAppears) {
  for (const bool lamp_goes : {true, false}) {
    SceneBuilderForTests b;
    b.place(b.add_mesh(square_of(b.add_material(lambert(Rgb(0.0f))))));
    b.place(b.add_mesh(square_of(b.add_material(emitter(Rgb(1.0f))))));
    b.description.instances[lamp_goes].visibility = visible_from(true, {.7f});
    expect_seen(lamp_goes ? "lamp that leaves its wall at .7" : "wall that leaves its lamp at .7",
                b, lamp_goes ? .7 : 1);
  }
}

TEST(Blink, ShadowsThatVanish) {
  for (const bool point : {true, false}) {
    SceneBuilderForTests b = white_floor();
    double steady = lamp_irradiance([](double) { return 1.0; });
    if (point) {
      b.add_point_light({1.3, 2, .1}, Rgb(1.0f));
      steady = 2 / std::pow(5, 1.5);
    } else {
      add_lamp(b);
    }
    // The card lies between the lamp and the floor. The camera is below the card.
    MaterialDescription card = lambert(Rgb(0.0f));
    card.double_sided = true;
    b.add_quad({.5f, 1, -1}, {.5f, 1, 1}, {2, 1, 1}, {2, 1, -1}, b.add_material(card));
    b.description.instances.back().visibility = visible_from(true, {.4f});
    expect_irradiance_at(
        kCase, b, .6 * steady, 2e-5,
        std::string("shadow of a ") + (point ? "point light" : "lamp") + " that vanishes");
  }
}

// A lamp that exists for part of the time contributes only then, and other lights lose nothing.
TEST(Blink, ALampThatAppears) {
  SceneBuilderForTests b = white_floor();
  add_lamp(b);
  b.description.instances.back().visibility = visible_from(false, {.1f, .35f});
  const double steady = lamp_irradiance([](double) { return 1.0; });
  expect_irradiance_at(kCase, b, .25 * steady, 2e-5, "lamp that is there for .25");
  b.add_point_light({.1, .8, 0}, Rgb(1.0f));
  b.description.lights[0].visibility = visible_from(true, {.5f});
  expect_irradiance_at(kCase, b, .25 * steady + .5 * unit_irradiance(), 2e-5,
                       "lamp and point light that appear");
}

// ---- lenses ----------------------------------------------------------------------------------

// A wall emits above y = .3. The row of pixels in the middle of the picture's upper half sees light
// while its lines of sight meet the wall above that edge.
TEST(Blink, Zooms) {
  SceneBuilderForTests b;
  b.add_quad({-9, .3f, 0}, {9, .3f, 0}, {9, 9, 0}, {-9, 9, 0}, b.add_material(emitter(Rgb(1.0f))));
  const auto scene = b.build();
  for (const bool ortho : {true, false}) {
    CameraDescription view =
        ortho ? orthographic({0, 0, 1}, {0, 0, 0}, .4) : perspective({0, 0, 1}, {0, 0, 0}, 1);
    view.zoom = over_time<double>({.1f, .9f, .9f}, {.4, 1.2, .2});
    view.fov_y = .4;
    const CaseName name{kCase, ortho ? "orthographic zoom" : "zoom"};
    RenderSettings s = direct_light_settings(4096);
    s.seed = seed_of(name);
    s.width = s.height = 64;
    s.crop = {0, 16, 64, 17};
    const RenderedImage image = render(*scene, view, s);
    // Row 16 of 64 spans .5 to .469 of half the picture's height, measured upwards from the middle.
    double exact = 0;
    constexpr int kTimes = 200'000;
    for (int i = 0; i < kTimes; ++i) {
      const double t = (i + .5) / kTimes;
      const double size = t < .1 ? .4 : t < .9 ? .4 + (t - .1) : .2;
      const double half = ortho ? size : std::tan(size / 2);
      const double top = .5 * half, bottom = 15.0 / 32 * half;
      exact += std::clamp((top - .3) / (top - bottom), 0.0, 1.0) / kTimes;
    }
    Moments values;
    for (int x = 0; x < 64; ++x) values.add(double(image.rgb(x, 16).y));
    expect_case(name, {exact, values.mean(), values.standard_error(), 1e-5}, replay(s));
  }
}

}  // namespace
}  // namespace emberline
