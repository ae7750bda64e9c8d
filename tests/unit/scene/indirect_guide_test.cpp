#include "renderer/scene/indirect_guide.h"

#include <gtest/gtest.h>

#include "renderer/core/parallel.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using test::TestRandom;

constexpr Vec3f kUp(0, 1, 0), kDown(0, -1, 0);

// Paths between a floor and a ceiling one unit above it. Only the floor gets direct light, which
// varies by 50 % from vertex to vertex. If `open`, every fourth ray leaves the scene and meets
// light of 2.
std::vector<SurveyVertex> paths_between(float albedo, float direct, bool open = false) {
  std::vector<SurveyVertex> vertices;
  for (uint64_t i = 0; i < 4000; ++i) {
    TestRandom random(1, i);
    for (int k = 0; k < 6; ++k) {
      const bool floor = k % 2 == 0;
      SurveyVertex v;
      v.position = {random.next(), floor ? 0.0f : 1.0f, random.next()};
      v.orientation = IndirectGuide::orientation_of(floor ? kUp : kDown);
      v.albedo = albedo;
      v.samples_lights = true;
      v.direct = floor ? albedo * direct * (0.5f + random.next()) : 0.0f;
      v.is_first = k == 0;
      v.is_diffuse = true;
      v.bin = uint8_t(random.bits());
      v.weight = albedo;
      v.next = k < 5 ? SurveyVertex::Next::kSurface : SurveyVertex::Next::kUnknown;
      if (open && random.next() < 0.25f) {
        v.next = SurveyVertex::Next::kNothing;
        v.incoming = 2.0f;
      }
      vertices.push_back(v);
      if (v.next == SurveyVertex::Next::kNothing) break;
    }
  }
  return vertices;
}

// With floor light f = d + a c and ceiling light c = a f: f = d / (1 - a^2).
TEST(IndirectGuide, SolvesForTheLightBetweenSurfaces) {
  for (const float albedo : {0.2f, 0.5f}) {
    std::vector<SurveyVertex> vertices = paths_between(albedo, 3.0f);
    const IndirectGuide guide(vertices);
    ASSERT_FALSE(guide.empty());
    const float floor = 3.0f / (1 - albedo * albedo);
    double direct = 0, indirect = 0, above = 0;
    constexpr int kPoints = 100;
    for (int i = 0; i < kPoints; ++i) {
      const Vec2f p = TestRandom(2, uint64_t(i)).vec2();
      const GuideCell* low = guide.find({p.x, 0, p.y}, kUp);
      const GuideCell* high = guide.find({p.x, 1, p.y}, kDown);
      ASSERT_TRUE(low && high);
      direct += double(low->direct) / kPoints;
      indirect += double(low->indirect) / kPoints;
      above += double(high->direct + high->indirect) / kPoints;
    }
    EXPECT_NEAR(direct, 3.0, 0.1);
    EXPECT_NEAR(indirect, double(floor) - 3, 0.02 * double(floor));
    EXPECT_NEAR(above, double(albedo * floor), 0.02 * double(floor));
    EXPECT_NEAR(guide.indirect_fraction(), double(albedo * albedo), 0.02);
  }
}

TEST(IndirectGuide, CountsLightFromOutside) {
  std::vector<SurveyVertex> vertices = paths_between(0.0001f, 1.0f, /*open=*/true);
  const IndirectGuide guide(vertices);
  const GuideCell* cell = guide.find({0.5f, 0, 0.5f}, kUp);
  ASSERT_TRUE(cell);
  EXPECT_NEAR(cell->indirect, 0.5f, 0.2f);
  EXPECT_LT(guide.indirect_fraction(), 0.01);
}

// Guided rays go to the bright half of the directions nine times in ten. The mean does not change.
TEST(IndirectGuide, GuidedRaysKeepTheMean) {
  std::vector<SurveyVertex> vertices = paths_between(0.0001f, 1.0f, /*open=*/true);
  for (size_t i = 0; i < vertices.size(); ++i) {
    SurveyVertex& v = vertices[i];
    TestRandom random(4, i);
    const bool bright = random.next() < 0.9f;
    v.bin = uint8_t(random.bits() % 128 + (bright ? 0 : 128));
    v.weight = v.albedo / (bright ? 1.8f : 0.2f);
    v.next = SurveyVertex::Next::kNothing;
    v.incoming = bright ? 2.0f : 0.0f;
  }
  const IndirectGuide guide(vertices);
  EXPECT_NEAR(guide.find({0.5f, 0, 0.5f}, kUp)->indirect, 1.0f, 0.05f);
}

TEST(IndirectGuide, SeparatesSidesAndAxes) {
  std::vector<SurveyVertex> vertices = paths_between(0.5f, 1.0f);
  const IndirectGuide guide(vertices);
  EXPECT_NE(guide.find({0.5f, 0.5f, 0.5f}, kUp), guide.find({0.5f, 0.5f, 0.5f}, kDown));
  EXPECT_EQ(guide.find({0.5f, 0.5f, 0.5f}, {1, 0, 0}), nullptr);
  // Points outside the survey are in the nearest cells.
  EXPECT_NE(guide.find({-1e30f, 1e30f, kInfinity}, kUp), nullptr);
  // A wall whose normal has z = 0 may have either sign of zero, and its frames differ.
  EXPECT_NE(IndirectGuide::orientation_of({1, 0, 0.0f}),
            IndirectGuide::orientation_of({1, 0, -0.0f}));
}

// The guide prefers the directions that light comes from, and never leaves out a direction.
TEST(IndirectGuide, PrefersBrightDirections) {
  std::vector<SurveyVertex> vertices;
  for (uint64_t i = 0; i < 200000; ++i) {
    TestRandom random(4, i);
    SurveyVertex v;
    v.position = {random.next(), 0, random.next()};
    v.orientation = IndirectGuide::orientation_of(kUp);
    v.albedo = v.weight = 0.5f;
    v.is_first = v.is_diffuse = true;
    v.bin = uint8_t(random.bits());
    v.next = SurveyVertex::Next::kNothing;
    v.incoming = v.bin == 100 ? 50.0f : 0.0f;
    vertices.push_back(v);
  }
  const IndirectGuide guide(vertices);
  const CosineGuide& directions = guide.find({0.5f, 0, 0.5f}, kUp)->directions;
  int bright = 0;
  constexpr int kPoints = 2000;
  for (uint64_t i = 0; i < kPoints; ++i) {
    const Vec3f w = CosineGuide::direction_of(directions.sample(TestRandom(6, i).vec2()));
    EXPECT_GE(directions.density(w), 0.2f);
    bright += CosineGuide::bin_of(w) == 100;
  }
  EXPECT_GT(bright, 10 * kPoints / CosineGuide::kBins);
}

TEST(IndirectGuide, SurvivesVerticesInOnePlace) {
  std::vector<SurveyVertex> vertices = paths_between(0.5f, 1.0f);
  for (SurveyVertex& v : vertices) v.position = Vec3f(0.0f);
  for (size_t i = 0; i < 10; ++i) vertices[i].position.x = 1.0f;
  EXPECT_FALSE(IndirectGuide(vertices).empty());
  vertices.clear();
  EXPECT_TRUE(IndirectGuide(vertices).empty());
  EXPECT_EQ(IndirectGuide(vertices).find(Vec3f(0.0f), kUp), nullptr);
}

}  // namespace
}  // namespace emberline
