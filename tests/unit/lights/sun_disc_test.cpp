// Tests a sun in front of an environment map: its position, its irradiance and its share of the
// samples.
#include <gtest/gtest.h>

#include <cstring>

#include "renderer/core/moments.h"
#include "renderer/core/warps.h"
#include "renderer/description/scene_description.h"
#include "renderer/lights/environment_light.h"
#include "support/chi_square.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using test::ChiSquarePoint;
using test::ChiSquareSettings;
using test::TestRandom;

constexpr float kTrueRadius = 0.265f * kPi / 180;

// A grey sky that is brighter towards +Y.
std::shared_ptr<const Image> sky() {
  auto image = std::make_shared<Image>();
  image->width = 16;
  image->height = 8;
  image->channels = 3;
  image->type = TexelType::kFloat;
  std::vector<float> rgb;
  for (int y = 0; y < image->height; ++y)
    rgb.insert(rgb.end(), size_t(3 * image->width), 8.0f - float(y));
  image->texels.resize(rgb.size() * sizeof(float));
  std::memcpy(image->texels.data(), rgb.data(), image->texels.size());
  return image;
}

EnvironmentLight light_of(const SunDisc& sun, float degrees = 0.0f, float compensation = 0.0f) {
  return {sky(), 1.0f, degrees, {compensation, &sun}};
}

SunDisc sun_of(const Vec3f& direction, float radius, float irradiance = 100.0f) {
  return {direction.normalized(), radius, Rgb(irradiance, 0.5f * irradiance, 0.25f * irradiance)};
}

// Estimates the sun's contribution to a surface that faces it, with samples over the whole sphere.
TEST(SunDisc, GivesItsIrradiance) {
  for (const float radius : {kTrueRadius, 0.05f}) {
    const SunDisc sun = sun_of({1, 2, -3}, radius);
    const EnvironmentLight with = light_of(sun), without(sky(), 1.0f, 0.0f, {0.0f});
    Moments difference;
    for (uint64_t draw = 0; draw < 200'000; ++draw) {
      const EnvironmentSample s = with.sample(TestRandom(3, draw).vec2());
      const Rgb sky_alone = test::radiance_of(without, s.direction);
      const float facing = std::max(0.0f, dot(s.direction, sun.direction));
      if (s.pdf > 0) difference.add(double((s.radiance - sky_alone).x * facing / s.pdf));
    }
    // The cosine falls towards the edge of the disc, by 1e-3 at the larger radius.
    EXPECT_NEAR(difference.mean(), 100.0, 5 * difference.standard_error() + 0.13) << radius;
  }
}

TEST(SunDisc, SamplesHaveTheirDensity) {
  for (const float irradiance : {1000.0f, 3.0f, 0.2f}) {
    for (const float compensation : {0.0f, 1.0f}) {
      const EnvironmentLight light =
          light_of(sun_of({1, 1, 0.3f}, 0.3f, irradiance), 77, compensation);
      ChiSquareSettings settings;
      settings.tests = 6;
      EXPECT_TRUE(test::chi_square_directions(
          [&](TestRandom& r) { return std::optional(light.sample(r.vec2()).direction); },
          [&](const Vec3f& w) { return double(test::pdf_of(light, w)); }, settings))
          << irradiance << " " << compensation;
    }
  }
}

TEST(SunDisc, SampleAndLookupAgree) {
  const EnvironmentLight light = light_of(sun_of({-1, 0.4f, 0.7f}, kTrueRadius), 12);
  int on_the_sun = 0;
  for (uint64_t draw = 0; draw < 20'000; ++draw) {
    const EnvironmentSample s = light.sample(TestRandom(4, draw).vec2());
    ASSERT_NEAR(s.direction.length(), 1, 1e-6f);
    float pdf = 0;
    const Rgb radiance = light.radiance_and_pdf(s.direction, &pdf);
    EXPECT_EQ(test::radiance_of(light, s.direction), radiance);
    EXPECT_EQ(test::pdf_of(light, s.direction), pdf);
    EXPECT_NEAR(s.pdf, pdf, 2e-3f * pdf);
    EXPECT_NEAR(s.radiance.x, radiance.x, 2e-3f * radiance.x);
    on_the_sun += radiance.x > 1000;
  }
  EXPECT_NEAR(on_the_sun, 10'000, 400);
}

// A rotation of 90 degrees moves +X to -Z. The sun's intensity and colour change with those of the
// map.
TEST(SunDisc, GoesWithTheMap) {
  EnvironmentLight light = light_of(sun_of({1, 0, 0}, 0.1f));
  const float bright = test::radiance_of(light, {1, 0, 0}).x;
  EXPECT_GT(bright, 1000);
  EXPECT_LT(test::radiance_of(light, {0, 0, -1}).x, 10);
  const float mean = light.mean_luminance();
  light.adjust({0.5f, Rgb(1, 0, 1), 90});
  EXPECT_NEAR(test::radiance_of(light, {0, 0, -1}).x, 0.5f * bright, 1e-3f * bright);
  EXPECT_EQ(test::radiance_of(light, {0, 0, -1}).y, 0);
  EXPECT_LT(test::radiance_of(light, {1, 0, 0}).x, 10);
  EXPECT_LT(light.mean_luminance(), 0.5f * mean);
  light.adjust({1.0f, Rgb(1.0f), -90});
  EXPECT_NEAR(test::radiance_of(light, {0, 0, 1}).x, bright, 1e-3f * bright);
  light.adjust({0.0f, Rgb(1.0f), 0});
  EXPECT_EQ(test::radiance_of(light, {1, 0, 0}), Rgb(0.0f));
  EXPECT_EQ(light.sample({0.1f, 0.5f}).pdf, 0);
}

TEST(SunDisc, SetsAndDarkensTowardsItsEdge) {
  const EnvironmentLight light = light_of(sun_of({1, 0, 0}, 0.1f));
  EXPECT_LT(test::radiance_of(light, Vec3f(1, -0.02f, 0).normalized()).x, 10);
  const auto at = [&](float out) {
    return test::radiance_of(light, Vec3f(std::cos(out), std::sin(out), 0)).x;
  };
  EXPECT_NEAR(at(0.0999f) / at(0.0f), 0.4, 0.03);
  EXPECT_GT(at(0.05f) / at(0.0f), 0.85);
  EXPECT_LT(at(0.101f), 10);
}

}  // namespace
}  // namespace emberline
