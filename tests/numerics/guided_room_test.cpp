// Rooms lit through a hole, where environment samples are guided (renderer/scene/light_survey.h).
// Their light agrees with a closed form, the noise is lower than without a guide, and no guide is
// built where it would not pay.
#include "receiver.h"
#include "renderer/lights/environment_guide.h"
#include "renderer/lights/light_guide.h"
#include "support/float_map.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr double kHeight = 3;
// The hole in the ceiling spans these x and z.
constexpr double kX0 = -.3, kX1 = .5, kZ0 = -.4, kZ1 = .2;

int two_sided(SceneBuilderForTests& b, float albedo) {
  MaterialDescription m = lambert(Rgb(albedo));
  m.double_sided = true;
  return b.add_material(m);
}

// Returns a room with a white floor and walls of albedo `walls`, scaled by `size` and moved to
// `at`.
SceneBuilderForTests room(float walls = 0, double size = 1, const Vec3d& at = Vec3d(0.0)) {
  SceneBuilderForTests b;
  const int wall = two_sided(b, walls), floor = two_sided(b, 1);
  const auto quad = [&](const Vec3d& p, const Vec3d& u, const Vec3d& v, int material) {
    const auto corner = [&](const Vec3d& c) { return Vec3f(at + c * size); };
    b.add_quad(corner(p), corner(p + u), corner(p + u + v), corner(p + v), material);
  };
  const double r = 2;
  quad({-r, 0, -r}, {2 * r, 0, 0}, {0, 0, 2 * r}, floor);
  quad({-r, 0, -r}, {0, kHeight, 0}, {2 * r, 0, 0}, wall);
  quad({-r, 0, r}, {0, kHeight, 0}, {2 * r, 0, 0}, wall);
  quad({-r, 0, -r}, {0, kHeight, 0}, {0, 0, 2 * r}, wall);
  quad({r, 0, -r}, {0, kHeight, 0}, {0, 0, 2 * r}, wall);
  quad({-r, kHeight, -r}, {kX0 + r, 0, 0}, {0, 0, 2 * r}, wall);
  quad({kX1, kHeight, -r}, {r - kX1, 0, 0}, {0, 0, 2 * r}, wall);
  quad({kX0, kHeight, -r}, {kX1 - kX0, 0, 0}, {0, 0, kZ0 + r}, wall);
  quad({kX0, kHeight, kZ1}, {kX1 - kX0, 0, 0}, {0, 0, r - kZ1}, wall);
  return b;
}

CameraDescription down_at(const Vec3d& floor, double size = 1) {
  return orthographic(floor + Vec3d(0, 0.2, 0) * size, floor, 1e-4 * size);
}

double exact_at(const Vec3d& floor) {
  const std::vector<Vec3d> hole = {
      {kX0, kHeight, kZ0}, {kX1, kHeight, kZ0}, {kX1, kHeight, kZ1}, {kX0, kHeight, kZ1}};
  return std::abs(polygon_irradiance(hole, floor, Vec3d(0, 1, 0))) / kPiD;
}

LightGuide guide_of(const Scene& scene, const CameraDescription& view, const RenderSettings& s) {
  const RenderPlan plan = plan_of(s);
  const Camera camera(view, s.width, s.height, scene.origin(), scene.scale());
  const auto guide = plan.frame(scene, camera).guide;
  return guide ? *guide : LightGuide();
}

bool is_guided(const Scene& scene, const CameraDescription& view, const RenderSettings& s) {
  return guide_of(scene, view, s).environment != nullptr;
}

RenderSettings by_light(RenderSettings s) {
  s.environment_sampling = EnvironmentSampling::kByLight;
  return s;
}

// Uses few samples. With many samples, smooth light through a simple hole is well stratified with
// and without a guide.
double noise_of(const Scene& scene, const CameraDescription& view, RenderSettings s) {
  s.spp = 16;
  s.width = s.height = 32;
  return render(scene, view, s).standard_error;
}

TEST(GuidedRoom, LightThroughAHole) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    const Vec3d at = Vec3d(3, -1, 2) * size;
    SceneBuilderForTests b = room(0, size, at);
    b.set_environment(Rgb(1.0f));
    const auto scene = b.build();
    for (const Vec3d& floor : {Vec3d(0.0), Vec3d(1.2, 0, -0.7)}) {
      const RenderSettings s = direct_light_settings();
      const CameraDescription view = down_at(at + floor * size, size);
      ASSERT_TRUE(is_guided(*scene, view, s)) << size;
      const RenderedImage guided = render(*scene, view, s);
      expect_exact(guided, exact_at(floor), 1e-4, s,
                   {"E49", fmt::format("room of size {:g}, light through a hole", size)});
      // Seen from directly below, the hole fills a small part of many tiles, and the guide gains
      // less.
      EXPECT_LT(noise_of(*scene, view, s),
                (floor.x == 0 ? 1.0 : 0.4) * noise_of(*scene, view, by_light(s)))
          << size;
    }
  }
}

// Returns a sky with a bright and a dark half, and a sun of several texels.
std::shared_ptr<const Image> sky_map() {
  return float_map(128, 64, [](int column, int row) {
    const bool sun = row >= 2 && row < 4 && column >= 30 && column < 40;
    return Rgb(sun ? 200.0f : column < 64 ? 0.5f : 2.0f);
  });
}

// With a guide the mean stays the same, even with reflections, a clear pane, other lamps, or a
// translucent leaf. The rendered spot is so small that its pixels differ only by noise.
TEST(GuidedRoom, HasTheMeanOfOneThatIsNot) {
  for (const std::string with : {"", "pane", "map", "lamps", "leaf"}) {
    SceneBuilderForTests b = room(0.5f);
    b.set_environment(Rgb(1.0f));
    if (with == "pane") {
      MaterialDescription glass;
      glass.metallic = 0.0f;
      glass.transmission = 1.0f;
      glass.roughness = 0.0f;
      glass.double_sided = true;
      b.add_quad({-.4f, 2.9f, -.5f}, {.6f, 2.9f, -.5f}, {.6f, 2.9f, .3f}, {-.4f, 2.9f, .3f},
                 b.add_material(glass));
    } else if (with == "map") {
      b.set_environment(sky_map());
    } else if (with == "lamps") {
      b.add_point_light({1.5, 1, 1}, Rgb(0.01f));
      b.add_quad({1.2f, .5f, -1.5f}, {1.3f, .5f, -1.5f}, {1.3f, .6f, -1.5f}, {1.2f, .6f, -1.5f},
                 b.add_material(emitter(Rgb(0.5f))));
    } else if (with == "leaf") {
      MaterialDescription leaf = lambert(Rgb(0.5f));
      leaf.diffuse_transmission = 0.5f;
      leaf.double_sided = true;
      b.add_quad({-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}, b.add_material(leaf));
    }
    const auto scene = b.build();
    const CameraDescription view = down_at({-0.8, 0, 0.9});
    RenderSettings s;
    s.width = s.height = 32;
    s.spp = 256;
    s.max_depth = 4;
    ASSERT_TRUE(is_guided(*scene, view, s)) << with;
    const RenderedImage guided = render(*scene, view, s);
    const RenderedImage light = render(*scene, view, by_light(s));
    const double error = std::hypot(guided.standard_error, light.standard_error);
    EXPECT_NEAR(guided.mean, light.mean, 5 * error) << with;
    s.light_samples = 3;
    const RenderedImage three = render(*scene, view, s);
    EXPECT_NEAR(three.mean, light.mean, 5 * std::hypot(three.standard_error, light.standard_error))
        << with;
    EXPECT_LT(error, 0.02 * light.mean) << with;
  }
}

// In a closed room under a bright sky, samples of the sky are wasted. The lamp's light has a closed
// form.
TEST(GuidedRoom, LampsAndASkyThatDoesNotArrive) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    const double power = 2;
    SceneBuilderForTests b = room(0, size);
    const int lid = two_sided(b, 0);
    const auto corner = [&](double x, double z) {
      return Vec3f(Vec3d(x, kHeight * 1.01, z) * size);
    };
    b.add_quad(corner(-2, -2), corner(2, -2), corner(2, 2), corner(-2, 2), lid);
    b.add_point_light(Vec3d(0.4, 1.5, 0.3) * size, Rgb(float(power * size * size)));
    b.set_environment(Rgb(50.0f));
    const auto scene = b.build();
    const Vec3d floor(-0.5, 0, 0.2);
    const CameraDescription view = down_at(floor * size, size);
    RenderSettings s = direct_light_settings();
    const KindFactors factors = guide_of(*scene, view, s).factors;
    EXPECT_LT(factors.environment, 0.25f) << size;
    EXPECT_EQ(factors.directional, 1.0f) << size;
    const Vec3d to_lamp = Vec3d(0.4, 1.5, 0.3) - floor;
    const double exact = power * to_lamp.y / std::pow(to_lamp.length(), 3) / kPiD;
    expect_exact(render(*scene, view, s), exact, 1e-4, s,
                 {"E51", fmt::format("closed room of size {:g}, a lamp, bright sky", size)});
    // The guide raises the lamp's share of the samples from 1 in 5 to 19 in 20.
    EXPECT_LT(noise_of(*scene, view, s), 0.5 * noise_of(*scene, view, by_light(s))) << size;
  }
}

// The room has a sun, a lamp and a sky, each of which is the brightest light somewhere.
TEST(GuidedRoom, KindsOfLightKeepTheirMean) {
  SceneBuilderForTests b = room(0.5f);
  b.set_environment(sky_map());
  PunctualLightDescription sun;
  sun.type = PunctualType::kDirectional;
  sun.intensity = Rgb(30.0f);
  sun.to_world = look_at_matrix({0.3, 5, 0.2}, {0, 0, 0});
  b.description.lights.push_back(sun);
  b.add_quad({1.2f, .5f, -1.5f}, {1.3f, .5f, -1.5f}, {1.3f, .6f, -1.5f}, {1.2f, .6f, -1.5f},
             b.add_material(emitter(Rgb(5.0f))));
  const auto scene = b.build();
  const CameraDescription view = down_at({-0.8, 0, 0.9});
  RenderSettings s;
  s.width = s.height = 32;
  s.spp = 512;
  s.max_depth = 4;
  ASSERT_NE(guide_of(*scene, view, s).factors, KindFactors{});
  const RenderedImage guided = render(*scene, view, s);
  const RenderedImage light = render(*scene, view, by_light(s));
  EXPECT_NE(guided.values, light.values);
  const double error = std::hypot(guided.standard_error, light.standard_error);
  EXPECT_NEAR(guided.mean, light.mean, 5 * error);
  EXPECT_LT(guided.standard_error, light.standard_error);
  EXPECT_LT(error, 0.02 * light.mean);
}

// Guided samples have the same bits for any number of threads, and for all buckets, crops and
// drivers.
TEST(GuidedRoom, EqualSamplesHaveEqualBits) {
  SceneBuilderForTests b = room(0.5f);
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const CameraDescription view = perspective({1.5, 2, 1.5}, {0, 0.5, 0}, 70);
  RenderSettings s;
  s.width = 31;
  s.height = 23;
  s.max_depth = 3;
  s.threads = 1;
  ASSERT_TRUE(is_guided(*scene, view, s));
  const RenderedImage whole = render(*scene, view, s);
  const RenderedImage light = render(*scene, view, by_light(s));
  EXPECT_NE(whole.values, light.values);
  s.threads = 3;
  s.bucket_size = 7;
  EXPECT_EQ(render(*scene, view, s).values, whole.values);
  s.driver = "bisection";
  EXPECT_EQ(render(*scene, view, s).values, whole.values);
  s.crop = {5, 3, 20, 17};
  const RenderedImage crop = render(*scene, view, s);
  for (int y = s.crop.y0; y < s.crop.y1; ++y) {
    for (int x = s.crop.x0; x < s.crop.x1; ++x) EXPECT_EQ(crop.rgb(x, y), whole.rgb(x, y));
  }
}

TEST(GuidedRoom, NoGuideWhenStopped) {
  SceneBuilderForTests b = room();
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const CameraDescription view = perspective({1.5, 2, 1.5}, {0, 0.5, 0}, 70);
  const RenderSettings s;
  ASSERT_TRUE(is_guided(*scene, view, s));
  std::stop_source stop;
  stop.request_stop();
  const Camera camera(view, s.width, s.height, scene->origin(), scene->scale());
  const Frame frame = plan_of(s).frame(*scene, camera, {}, stop.get_token());
  EXPECT_FALSE(frame.guide);
  EXPECT_FALSE(frame.indirect.guide);
}

TEST(GuidedRoom, NoGuideWhereItDoesNotPay) {
  const CameraDescription view = perspective({1.5, 2, 1.5}, {0, 0.5, 0}, 70);
  const RenderSettings s;
  const auto expect_none = [&](const SceneBuilderForTests& b, const std::string& why) {
    EXPECT_FALSE(is_guided(*b.build(), view, s)) << why;
  };
  SceneBuilderForTests dark = room();
  dark.set_environment(Rgb(0.0f));
  expect_none(dark, "black");
  SceneBuilderForTests lamp = room();
  lamp.set_environment(Rgb(1.0f));
  lamp.add_point_light({0, 1.5, 0}, Rgb(10.0f));
  expect_none(lamp, "a lamp");
  SceneBuilderForTests closed = room();
  closed.set_environment(Rgb(1.0f));
  closed.add_floor(3, float(kHeight) + 0.1f, two_sided(closed, 0));
  expect_none(closed, "a closed room");
  SceneBuilderForTests open;
  open.add_floor(10, 0, two_sided(open, 1));
  open.set_environment(Rgb(1.0f));
  expect_none(open, "the open");
  SceneBuilderForTests empty;
  empty.set_environment(Rgb(1.0f));
  expect_none(empty, "nothing");
}

}  // namespace
}  // namespace emberline
