// Tests environment samples guided by the visibility in regions of a scene: their pdfs, and the
// regions.
#include "renderer/lights/environment_guide.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "renderer/description/scene_description.h"
#include "support/chi_square.h"
#include "support/float_map.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using test::chi_square_directions;
using test::ChiSquareSettings;
using test::float_map;
using test::TestRandom;

constexpr float kInf = std::numeric_limits<float>::infinity();

std::shared_ptr<const Image> map_of(int width, int height, bool spikes) {
  return float_map(width, height, [&](int column, int row) {
    TestRandom random(7, uint64_t(row * width + column));
    const float bright = spikes && random.next() < 0.01f ? 300.0f : 1.0f;
    const float red = random.next(), green = random.next();
    return Rgb(red, green, random.next()) * bright;
  });
}

// Returns one region of points that face upwards. `visibility` gives the visibility of each tile
// from there.
SkyRegions one_region(const std::function<float(int tile)>& visibility, uint32_t places = 100) {
  SkyRegions regions(Vec3f(-1.0f), Vec3f(1.0f));
  const int region = regions.find_or_add(Vec3f(0.0f), Vec3f(0, 1, 0));
  for (int tile = 0; tile < sky_tiles::kCount; ++tile) {
    regions.visibility(region)[size_t(tile)] = visibility(tile);
  }
  regions.places(region) = places;
  return regions;
}

// Most tiles are closed, and the others are partly open.
float through_a_window(int tile) {
  TestRandom random(3, uint64_t(tile));
  return random.next() < 0.2f ? random.next() : 0.0f;
}

EnvironmentSample sample_of(const EnvironmentGuide& guide, TestRandom& random, int region = 0) {
  const float u_part = random.next();
  const GuidedRequest request{region, u_part, random.vec2()};
  EnvironmentSample sample;
  guide.sample({&request, 1}, &sample);
  return sample;
}

Rgb look(const EnvironmentGuide& guide, const Vec3f& direction, float* pdf, int region = 0) {
  Rgb radiance;
  guide.radiance_and_pdf({&direction, 1}, {&region, 1}, &radiance, pdf);
  return radiance;
}

struct LightCase {
  std::string name;
  std::shared_ptr<const EnvironmentLight> light;
};

std::vector<LightCase> lights() {
  std::vector<LightCase> cases;
  cases.push_back({"constant", std::make_shared<EnvironmentLight>(Rgb(0.5f))});
  for (const float compensation : {0.0f, 1.0f}) {
    const EnvironmentLightSettings settings{.mis_compensation = compensation};
    for (const auto& [width, height, rotation] :
         {std::tuple(64, 32, 0.0f), std::tuple(90, 45, 77.0f), std::tuple(7, 5, -130.0f),
          std::tuple(2, 1, 0.0f), std::tuple(1, 1, 10.0f)}) {
      const auto image = map_of(width, height, width > 50);
      cases.push_back({fmt::format("{} x {}, {}", width, height, compensation),
                       std::make_shared<EnvironmentLight>(image, 2.0f, rotation, settings)});
    }
  }
  SunDisc sun;
  sun.direction = Vec3f(0.6f, 0.64f, 0.48f);
  sun.radius = 0.1f;
  sun.irradiance = Rgb(2.0f);
  cases.push_back({"sun", std::make_shared<EnvironmentLight>(
                              map_of(64, 32, false), 1.0f, 30.0f,
                              EnvironmentLightSettings{.mis_compensation = 1, .sun = &sun})});
  return cases;
}

TEST(SkyTiles, ADirectionIsInItsTile) {
  for (int tile = 0; tile < sky_tiles::kCount; ++tile) {
    for (uint64_t draw = 0; draw < 50; ++draw) {
      TestRandom random(uint64_t(tile), draw);
      const Vec2f u = random.vec2() * 0.998f + Vec2f(0.001f);  // not within rounding of an edge
      const Vec3f direction = sky_tiles::direction_in(tile, u);
      EXPECT_NEAR(direction.length(), 1.0f, 1e-6f);
      EXPECT_EQ(sky_tiles::tile_of(direction), tile) << direction.x << " " << direction.y;
    }
  }
  for (const Vec3f& d : {Vec3f(0, 1, 0), Vec3f(0, -1, 0), Vec3f(-1, 0, 0), Vec3f(-1, 0, -0.0f)}) {
    const int tile = sky_tiles::tile_of(d);
    EXPECT_TRUE(tile >= 0 && tile < sky_tiles::kCount);
  }
}

TEST(SkyRegions, AreFoundAgain) {
  SkyRegions regions(Vec3f(-2, -1, 5), Vec3f(2, 1, 9));
  std::vector<int> made;
  for (uint64_t draw = 0; draw < 2000; ++draw) {
    TestRandom random(1, draw);
    const Vec3f point(random.next() * 4 - 2, random.next() * 2 - 1, random.next() * 4 + 5);
    const Vec3f normal(random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f);
    made.push_back(regions.find_or_add(point, normal));
    EXPECT_NE(made.back(), SkyRegions::kNone);
    EXPECT_EQ(regions.find(point, normal), made.back());
    EXPECT_NE(regions.find(point, -normal), made.back());  // the other side of a wall
  }
  EXPECT_GT(regions.count(), 1000);
  EXPECT_EQ(*std::ranges::max_element(made), regions.count() - 1);
  for (const Vec3f& outside : {Vec3f(-2.1f, 0, 7), Vec3f(0, 1.1f, 7), Vec3f(0, 0, 1e30f),
                               Vec3f(kInf, 0, 7), Vec3f(std::nanf(""), 0, 7)}) {
    EXPECT_EQ(regions.find(outside, Vec3f(0, 1, 0)), SkyRegions::kNone);
    EXPECT_EQ(regions.find_or_add(outside, Vec3f(0, 1, 0)), SkyRegions::kNone);
  }
}

TEST(SkyRegions, BoxesWithoutSize) {
  for (const auto& [lower, upper] :
       {std::pair(Vec3f(1.0f), Vec3f(1.0f)), std::pair(Vec3f(1.0f), Vec3f(-1.0f)),
        std::pair(Vec3f(0.0f), Vec3f(kInf)), std::pair(Vec3f(0.0f), Vec3f(1e-42f, 0, 0)),
        std::pair(Vec3f(std::nanf("")), Vec3f(1.0f))}) {
    SkyRegions regions(lower, upper);
    EXPECT_EQ(regions.find_or_add(Vec3f(1.0f), Vec3f(0, 1, 0)), SkyRegions::kNone);
  }
  SkyRegions flat(Vec3f(0.0f), Vec3f(1, 0, 1));
  EXPECT_NE(flat.find_or_add(Vec3f(0.5f, 0, 0.5f), Vec3f(0, 1, 0)), SkyRegions::kNone);
}

TEST(SkyRegions, AreLimitedInNumber) {
  SkyRegions regions(Vec3f(0.0f), Vec3f(32.0f));
  int last = SkyRegions::kNone;
  for (int i = 0; i < 32 * 32 * 32; ++i) {
    const Vec3f point(float(i % 32) + 0.5f, float(i / 32 % 32) + 0.5f, float(i / 1024) + 0.5f);
    for (const float up : {1.0f, -1.0f}) last = regions.find_or_add(point, Vec3f(0, up, 0));
  }
  EXPECT_EQ(last, SkyRegions::kNone);
  EXPECT_EQ(regions.count(), 4096);
  EXPECT_EQ(regions.find(Vec3f(0.5f), Vec3f(0, 1, 0)), 0);
}

// Correctness requires only that samples have the stated pdf.
TEST(EnvironmentGuide, SamplesHaveTheDensityThatTheyState) {
  const std::vector<LightCase> cases = lights();
  for (const auto& [name, light] : cases) {
    EnvironmentGuide guide(*light);
    guide.set_regions(one_region(through_a_window));
    ChiSquareSettings settings;
    settings.tests = int(cases.size());
    settings.samples = 200'000;
    EXPECT_TRUE(chi_square_directions(
        [&](TestRandom& random) { return std::optional(sample_of(guide, random).direction); },
        [&](const Vec3f& direction) {
          float pdf;
          look(guide, direction, &pdf);
          return double(pdf);
        },
        settings))
        << name;
  }
}

TEST(EnvironmentGuide, SampleMatchesALookupInItsDirection) {
  for (const auto& [name, light] : lights()) {
    EnvironmentGuide guide(*light);
    guide.set_regions(one_region(through_a_window));
    int differ = 0;
    for (uint64_t draw = 0; draw < 4000; ++draw) {
      TestRandom random(11, draw);
      const EnvironmentSample s = sample_of(guide, random);
      ASSERT_GT(s.pdf, 0.0f) << name;
      float pdf;
      const Rgb radiance = look(guide, s.direction, &pdf);
      // At the edge of a tile or of the sun, rounding may choose the other side of the edge.
      const bool same = std::abs(pdf - s.pdf) <= 1e-2f * s.pdf &&
                        (radiance - s.radiance).length() <= 1e-2f * s.radiance.length();
      differ += same ? 0 : 1;
    }
    EXPECT_LE(differ, 8) << name;
  }
}

// Without knowledge, or with the same visibility everywhere, samples follow the light.
TEST(EnvironmentGuide, WithoutKnowledgeGoesByLight) {
  const EnvironmentLight light(map_of(64, 32, false), 1.0f, 0.0f,
                               EnvironmentLightSettings{.mis_compensation = 0});
  for (const float visibility : {0.0f, 0.7f}) {
    EnvironmentGuide guide(light);
    guide.set_regions(one_region([&](int) { return visibility; }));
    for (uint64_t draw = 0; draw < 500; ++draw) {
      TestRandom random(13, draw);
      const EnvironmentSample s = sample_of(guide, random);
      EXPECT_NEAR(s.pdf, test::pdf_of(light, s.direction), 1e-3f * s.pdf);
    }
  }
}

TEST(EnvironmentGuide, PointsOfNoRegionHaveTheLightsOwnBits) {
  for (const auto& [name, light] : lights()) {
    EnvironmentGuide guide(*light);
    guide.set_regions(one_region(through_a_window));
    for (uint64_t draw = 0; draw < 200; ++draw) {
      TestRandom random(17, draw), again(17, draw);
      again.next();
      const EnvironmentSample s = sample_of(guide, random, SkyRegions::kNone);
      const EnvironmentSample own = light->sample(again.vec2());
      EXPECT_EQ(s.direction, own.direction) << name;
      EXPECT_EQ(s.pdf, own.pdf) << name;
      float pdf, own_pdf;
      EXPECT_EQ(look(guide, s.direction, &pdf, SkyRegions::kNone),
                light->radiance_and_pdf(s.direction, &own_pdf));
      EXPECT_EQ(pdf, own_pdf) << name;
    }
  }
}

// In a batch of mixed requests, each request gets what it would get alone.
TEST(EnvironmentGuide, ABatchIsItsSamples) {
  for (const auto& [name, light] : lights()) {
    EnvironmentGuide guide(*light);
    guide.set_regions(one_region(through_a_window));
    GuidedRequest requests[kRayBatch];
    for (int i = 0; i < kRayBatch; ++i) {
      TestRandom random(19, uint64_t(i));
      const float u_part = random.next();
      requests[i] = {i % 3 == 0 ? SkyRegions::kNone : 0, u_part, random.vec2()};
    }
    EnvironmentSample together[kRayBatch];
    guide.sample(requests, together);
    for (int i = 0; i < kRayBatch; ++i) {
      EnvironmentSample alone;
      guide.sample({&requests[i], 1}, &alone);
      EXPECT_EQ(alone.direction, together[i].direction) << name;
      EXPECT_EQ(alone.radiance, together[i].radiance) << name;
      EXPECT_EQ(alone.pdf, together[i].pdf) << name;
    }
  }
}

// The open part has hardly any light, so guiding gains nothing. Nothing may overflow.
TEST(EnvironmentGuide, AnOpeningToTheDark) {
  for (const float dim : {1e-6f, 1e-20f, 1e-40f, 0.0f}) {
    const auto image = float_map(64, 32, [&](int, int row) { return Rgb(row < 16 ? dim : 1.0f); });
    const EnvironmentLight light(image, 1.0f, 0.0f);
    EnvironmentGuide guide(light);
    guide.set_regions(one_region([](int tile) { return tile < 100 ? 1.0f : 0.0f; }));
    for (uint64_t draw = 0; draw < 2000; ++draw) {
      TestRandom random(23, draw);
      const EnvironmentSample s = sample_of(guide, random);
      ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0.0f && is_finite(s.direction)) << dim;
      float pdf;
      look(guide, -s.direction, &pdf);
      ASSERT_TRUE(std::isfinite(pdf)) << dim;
    }
  }
}

// The tables omit a dim texel among black ones. It must still be sampled, because a shadow catcher
// has no other technique.
TEST(EnvironmentGuide, NothingThatShinesIsLeftOut) {
  constexpr int kWidth = 1024, kHeight = 512;
  for (int dot = 0; dot < 20; ++dot) {
    TestRandom random(29, uint64_t(dot));
    const int column = int(random.next() * kWidth), row = kHeight / 2 + int(random.next() * 250);
    const auto image = float_map(kWidth, kHeight, [&](int c, int r) {
      return Rgb(r < kHeight / 4 ? 1.0f : r == row && c == column ? 0.01f : 0.0f);
    });
    const EnvironmentLight light(image, 1.0f, 0.0f, {.mis_compensation = 1});
    EnvironmentGuide guide(light);
    guide.set_regions(SkyRegions::single_region());
    const double theta = (row + 0.5) * kPiD / kHeight;
    // Looks in every direction in which the texel may be.
    int found = 0;
    for (int c = 0; c < kWidth; ++c) {
      const double phi = (c + 0.5) * 2 * kPiD / kWidth;
      const Vec3f direction(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                            float(std::sin(theta) * std::sin(phi)));
      float pdf;
      const Rgb radiance = look(guide, direction, &pdf, guide.region_of(Vec3f(0.0f), {0, 1, 0}));
      if (luminance(radiance) < 1e-4f) continue;
      ++found;
      EXPECT_EQ(test::pdf_of(light, direction), 0.0f);
      EXPECT_GT(pdf, 0.0f) << dot;
    }
    EXPECT_GE(found, 1) << dot;
  }
}

// The fewer points contributed to the visibility of a region, the more samples ignore it.
TEST(EnvironmentGuide, TrustsFewPointsLess) {
  const EnvironmentLight light(Rgb(1.0f));
  const auto closed = [&](uint32_t places) {
    EnvironmentGuide guide(light);
    guide.set_regions(one_region([](int tile) { return tile < 12 ? 1.0f : 0.0f; }, places));
    float pdf;
    look(guide, Vec3f(0, -1, 0), &pdf);
    return pdf;
  };
  EXPECT_GT(closed(1), 1.5f * closed(1000));
  EXPECT_GT(closed(1000), 0.05f * test::pdf_of(light, {0, -1, 0}));
}

}  // namespace
}  // namespace emberline
