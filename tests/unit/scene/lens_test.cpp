// Compares the thin lens with its closed forms: rays, circles of confusion, and cameras without a
// lens.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/core/errors.h"
#include "renderer/core/warps.h"
#include "renderer/description/framing.h"
#include "support/long_tests.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline::test {
namespace {

constexpr int kWidth = 90, kHeight = 60;

CameraDescription with_lens(CameraDescription camera, double radius, double focus) {
  camera.lens_radius = radius;
  camera.focus_distance = focus;
  return camera;
}

Ray lens_ray(const Camera& camera, const Vec2f& film, const Vec2f& lens) {
  Ray ray;
  camera.rays({&film, 1}, {&lens, 1}, &ray);
  return ray;
}

// The point where a ray hits the plane at `depth` in front of a lens at `from` that looks at `at`.
Vec3d at_depth(const Ray& ray, const Vec3d& from, const Vec3d& at, double depth) {
  const Vec3d axis = (at - from).normalized(), origin(ray.origin), direction(ray.direction);
  return origin + direction * ((depth - (origin - from).dot(axis)) / direction.dot(axis));
}

// In scenes of all sizes, rays leave from the lens, and the rays of one film point meet in focus.
TEST(Lens, RaysOfAPointOfTheFilmMeetInFocus) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    const Vec3d from = Vec3d(1, 2, 5) * size;
    const CameraDescription view = perspective(from, Vec3d(0.0), 40);
    const double radius = 0.1 * size, focus = 4.0 * size;
    const Camera pinhole(view, kWidth, kHeight, Vec3d(0.0), 1.0);
    const Camera camera(with_lens(view, radius, focus), kWidth, kHeight, Vec3d(0.0), 1.0);
    ASSERT_TRUE(camera.has_lens());
    ASSERT_FALSE(pinhole.has_lens());
    const Vec3f middle = pinhole.ray({0, 0}).origin;
    std::mt19937 random(1);
    const auto number = [&] { return float(random()) * 0x1p-32f; };
    double max_distance = 0.0;
    for (int i = 0; i < 500; ++i) {
      const Vec2f film(number() * kWidth, number() * kHeight);
      const Vec2f lens(std::min(number(), 0x1.fffffep-1f), std::min(number(), 0x1.fffffep-1f));
      const Ray ray = lens_ray(camera, film, lens);
      EXPECT_NEAR(dot(ray.direction, ray.direction), 1.0f, 1e-6f);
      EXPECT_NEAR(camera.axial_depth(ray.origin, 0), 0.0, 2e-6 * size) << "off the lens's plane";
      const double distance = Vec3d(ray.origin - middle).length();
      EXPECT_LE(distance, radius * 1.00001);
      max_distance = std::max(max_distance, distance);
      const Vec3d sharp = at_depth(pinhole.ray(film), from, Vec3d(0.0), focus);
      EXPECT_LT((at_depth(ray, from, Vec3d(0.0), focus) - sharp).length(), 4e-6 * size);
    }
    EXPECT_GT(max_distance, 0.97 * radius);
  }
}

// The lens is so much farther from the origin than it is wide that rounding moves its points.
TEST(Lens, PointsInFocusAreSharpFarAway) {
  const Vec3d from(1e4, 0, 0), at(1e4 + 5, 0, 0);
  const CameraDescription view = perspective(from, at, 40);
  const Camera pinhole(view, kWidth, kHeight, Vec3d(0.0), 1.0);
  const Camera camera(with_lens(view, 1e-3, 5.0), kWidth, kHeight, Vec3d(0.0), 1.0);
  for (const Vec2f& lens : {Vec2f(0.1f, 0.2f), Vec2f(0.9f, 0.4f), Vec2f(0.5f, 0.99f)}) {
    const Vec3d sharp = at_depth(pinhole.ray({12, 50}), from, at, 5.0);
    const Vec3d seen = at_depth(lens_ray(camera, {12, 50}, lens), from, at, 5.0);
    EXPECT_LT((seen - sharp).length(), 5e-6);
  }
}

TEST(Lens, ItsMiddleIsThePinhole) {
  const CameraDescription view = perspective({1, 2, 5}, {0, 0, 0}, 40);
  const Camera pinhole(view, kWidth, kHeight, Vec3d(0.0), 1.0);
  const Camera camera(with_lens(view, 0.3, 4.0), kWidth, kHeight, Vec3d(0.0), 1.0);
  const Camera infinite(with_lens(view, 0.3, 1e15), kWidth, kHeight, Vec3d(0.0), 1.0);
  for (const Vec2f& film : {Vec2f(0, 0), Vec2f(45, 30), Vec2f(89.5f, 3.25f)}) {
    const Ray expected = pinhole.ray(film), ray = lens_ray(camera, film, {0.5f, 0.5f});
    EXPECT_EQ(ray.origin, expected.origin);
    EXPECT_LT((ray.direction - expected.direction).length(), 2e-7f);
    EXPECT_EQ(camera.ray(film).direction, expected.direction);
    // If the lens is focused at infinity, all rays of a film point are parallel.
    EXPECT_LT((lens_ray(infinite, film, {0.9f, 0.1f}).direction - expected.direction).length(),
              2e-7f);
  }
}

TEST(Lens, ARayDoesNotDependOnItsNeighbours) {
  const Camera camera(with_lens(perspective({1, 2, 5}, {0, 0, 0}, 40), 0.3, 4.0), kWidth, kHeight,
                      Vec3d(0.0), 1.0);
  std::mt19937 random(2);
  const auto number = [&] { return float(random() >> 8) * 0x1p-24f; };
  Vec2f film[kRayBatch], lens[kRayBatch];
  for (int i = 0; i < kRayBatch; ++i) {
    film[i] = {number() * kWidth, number() * kHeight};
    lens[i] = {number(), number()};
  }
  Ray together[kRayBatch];
  camera.rays(film, lens, together);
  for (int i = 0; i < kRayBatch; ++i) {
    const Ray alone = lens_ray(camera, film[i], lens[i]);
    EXPECT_EQ(alone.origin, together[i].origin);
    EXPECT_EQ(alone.direction, together[i].direction);
  }
}

TEST(Lens, RadiusMatchesTheFNumber) {
  // A lens of 50 mm over a film of 24 mm has 26.99 degrees. At f/2 it is 25 mm wide.
  EXPECT_NEAR(lens_radius(2.0, 2 * std::atan(12.0 / 50.0)), 0.0125, 1e-12);
  EXPECT_NEAR(lens_radius(16.0, kPiD / 2), 0.012 / 32, 1e-12);
}

TEST(Lens, NeedsAFocusAndAPerspectiveCamera) {
  const CameraDescription view = perspective({1, 2, 5}, {0, 0, 0}, 40);
  EXPECT_THROW(Camera(with_lens(view, 0.1, 0.0), 4, 4, Vec3d(0.0), 1.0), InputError);
  const Camera flat(with_lens(orthographic({1, 2, 5}, {0, 0, 0}, 1), 0.1, 3), 4, 4, Vec3d(0.0), 1);
  EXPECT_FALSE(flat.has_lens());
}

// A small lamp of side kLamp at `depth` in front of the camera at the origin.
constexpr float kLamp = 0.4f;
std::unique_ptr<Scene> lamp_ahead(float depth, double size) {
  SceneBuilderForTests b;
  const int lamp = b.add_material(emitter(Rgb(1.0f)));
  const float h = kLamp / 2 * float(size), z = -depth * float(size);
  b.add_quad({-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}, lamp);
  return b.build();
}

struct Blur {
  double energy = 0, x = 0, y = 0, variance = 0;  // per axis, in pixels
  double max_distance = 0;                        // from the centre, of a pixel with any light
};

Blur measure(const RenderedImage& image) {
  Blur blur;
  const int w = image.crop.width(), h = image.crop.height();
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const double value = double(image.rgb(x, y).x);
      const double dx = x + 0.5 - w / 2.0, dy = y + 0.5 - h / 2.0;
      blur.energy += value;
      blur.x += value * dx;
      blur.y += value * dy;
      blur.variance += value * (dx * dx + dy * dy) / 2;
      if (value > 0) blur.max_distance = std::max(blur.max_distance, std::hypot(dx, dy));
    }
  }
  blur.x /= blur.energy;
  blur.y /= blur.energy;
  blur.variance /= blur.energy;
  return blur;
}

RenderSettings lamp_settings(const std::string& sampler) {
  RenderSettings s;
  s.width = s.height = 64;
  s.spp = long_or_short(512u, 128u);
  s.sampler = sampler;
  s.max_depth = 1;
  return s;
}

// A lens of diameter A that is focused at f blurs a point at z to a uniform disc in the plane of
// focus. The diameter of the disc is A |z - f| / z, and its variance per axis is a sixteenth of the
// squared diameter. Energy is conserved: the lamp is parallel to the film and covers the same area
// of the plane of focus from every point of the lens. The bounds are five times the scatter of
// independent hits, with a false alarm in a million for each bound. The samples are stratified and
// scatter less. A further 0.02 square pixels are for treating a pixel's light as uniform over the
// pixel.
TEST(Lens, CirclesOfConfusionHaveTheirSize) {
  constexpr double kFov = 40, kDiameter = 0.6;
  const double half = std::tan(kFov / 2 * kPiD / 180);
  for (const double size : {1e-6, 1.0, 1e6}) {
    const CameraDescription view = perspective(Vec3d(0.0), Vec3d(0, 0, -size), kFov);
    for (const auto& [depth, focus] : {std::pair{4.0, 2.0}, {4.0, 8.0}, {3.0, 1e9}}) {
      SCOPED_TRACE(testing::Message() << size << ": at " << depth << ", focus " << focus);
      const auto scene = lamp_ahead(float(depth), size);
      const RenderSettings s = lamp_settings("sobol");
      const Blur sharp = measure(render(*scene, view, s));
      const Blur blur =
          measure(render(*scene, with_lens(view, kDiameter / 2 * size, focus * size), s));
      const double pixels = s.height / (2 * half);  // at distance 1
      const double confusion = kDiameter * std::abs(depth - focus) / (depth * focus) * pixels;
      const double lamp = double(kLamp) / depth * pixels;
      ASSERT_GT(confusion, 3.0);
      const double scatter = 5.0 / std::sqrt(lamp * lamp * s.spp);  // relative scatter of the hits
      EXPECT_NEAR(sharp.energy, lamp * lamp, scatter * lamp * lamp);
      EXPECT_NEAR(blur.energy, lamp * lamp, scatter * lamp * lamp);
      // The variance is the sum of those of the disc, the lamp and the pixel area.
      const double variance = confusion * confusion / 16 + lamp * lamp / 12 + 1.0 / 12;
      EXPECT_NEAR(blur.variance, variance, scatter * variance + 0.02);
      EXPECT_NEAR(blur.x, 0.0, scatter * std::sqrt(variance));
      EXPECT_NEAR(blur.y, 0.0, scatter * std::sqrt(variance));
      EXPECT_LT(blur.max_distance, confusion / 2 + lamp * 0.71 + 0.71);
      EXPECT_GT(blur.max_distance, confusion / 2 + lamp / 2 - 1.0);
    }
  }
}

TEST(Lens, PointsInFocusAreAsSharpAsThroughAPinhole) {
  const CameraDescription view = perspective(Vec3d(0.0), Vec3d(0, 0, -1), 40);
  const auto scene = lamp_ahead(4.0f, 1.0);
  for (const SamplerEntry& sampler : sampler_table()) {
    const RenderSettings s = lamp_settings(std::string(sampler.name));
    const RenderedImage sharp = render(*scene, view, s);
    const RenderedImage lens = render(*scene, with_lens(view, 0.3, 4.0), s);
    EXPECT_GT(sharp.mean, 0.0);
    // The film points are the same. A ray at the edge of the lamp may fall to either side of the
    // edge.
    for (size_t i = 0; i < sharp.values.size(); ++i) {
      EXPECT_NEAR(lens.values[i], sharp.values[i], 2.5f / float(s.spp)) << sampler.name << " " << i;
    }
  }
}

TEST(Lens, RadiusZeroHasThePinholesBits) {
  const CameraDescription view = perspective({0, 0.3, 1}, {0, 0, -4}, 40);
  const auto scene = lamp_ahead(4.0f, 1.0);
  const RenderSettings s = lamp_settings("sobol");
  expect_same_bits(render(*scene, with_lens(view, 0.0, 3.0), s), render(*scene, view, s),
                   "radius 0");
}

}  // namespace
}  // namespace emberline::test
