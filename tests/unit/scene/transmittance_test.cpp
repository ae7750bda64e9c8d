// Tests the transmittance of shadow rays through surfaces of partial coverage.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// The panes are across the Z axis, the k-th at z = k + 1.
std::unique_ptr<Scene> panes(const std::vector<float>& coverages) {
  SceneBuilderForTests b;
  for (size_t k = 0; k < coverages.size(); ++k) {
    MaterialDescription m = lambert(Rgb(0.5f));
    m.alpha = coverages[k];
    m.alpha_mode = AlphaMode::kBlend;
    m.double_sided = true;
    const float z = float(k) + 1;
    b.add_quad({-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}, b.add_material(m));
  }
  b.set_environment(Rgb(1.0f));
  return b.build();
}

// Points before and behind the panes, in the scene's internal space.
struct Ends {
  explicit Ends(const Scene& scene)
      : before((Vec3d(0.1, 0.2, 0.5) - scene.origin()) * scene.scale()),
        behind((Vec3d(0.1, 0.2, 200) - scene.origin()) * scene.scale()) {}
  Vec3f before, behind;
};

float transmittance(const Scene& scene) {
  const Ends ends(scene);
  return scene.transmittance(ends.before, ends.behind, 0, {});
}

TEST(Transmittance, IsTheProductOverAllPanes) {
  EXPECT_EQ(transmittance(*panes({})), 1.0f);
  EXPECT_EQ(transmittance(*panes({0.0f})), 1.0f);
  EXPECT_NEAR(transmittance(*panes({0.25f})), 0.75f, 1e-7);
  EXPECT_NEAR(transmittance(*panes({0.25f, 0.5f, 0.8f})), 0.075f, 1e-7);
  EXPECT_EQ(transmittance(*panes({0.25f, 1.0f, 0.5f})), 0.0f);
  EXPECT_NEAR(transmittance(*panes(std::vector<float>(100, 0.01f))), std::pow(0.99, 100), 1e-6);
  EXPECT_EQ(transmittance(*panes(std::vector<float>(100, 0.9f))), 0.0f);
}

// If the floats were multiplied in another order, the products would differ in their last bits.
TEST(Transmittance, DoesNotDependOnTheOrderOfThePanes) {
  std::vector<float> coverages;
  for (int k = 0; k < 40; ++k) coverages.push_back(0.01f + 0.002f * float(k));
  const float there = transmittance(*panes(coverages));
  EXPECT_GT(there, 0.0625f);
  const auto scene = panes(coverages);
  const Ends ends(*scene);
  EXPECT_EQ(scene->transmittance(ends.behind, ends.before, 0, {}), there);
  EXPECT_EQ(transmittance(*panes({coverages.rbegin(), coverages.rend()})), there);
}

// The fraction of camera rays that pass and the mean of the shadow rays equal the product to 4.5
// standard errors, both below and above the limit of Russian roulette.
TEST(Transmittance, IsHowOftenRaysPass) {
  constexpr uint32_t kRays = 65536;
  for (const std::vector<float>& coverages :
       {std::vector<float>{0.25f, 0.5f}, {0.75f, 0.9f}, {0.8f, 0.5f, 0.75f, 0.7f}}) {
    const auto scene = panes(coverages);
    const Ends ends(*scene);
    double expected = 1, passed = 0, sum = 0;
    for (const float c : coverages) expected *= 1 - double(c);
    for (uint32_t i = 0; i < kRays; ++i) {
      const CoverageKey key{hash32(i), i};
      SurfaceHit hit;
      passed += !scene->intersect({ends.before, ends.behind - ends.before, 1.0f, 0.0f}, key, &hit);
      const float through = scene->transmittance(ends.before, ends.behind, 0, key);
      EXPECT_TRUE(expected < 0.0625 ? through == 0.0f || through == 0.0625f : through > 0.0625f);
      sum += double(through);
    }
    const double error = 4.5 * std::sqrt(expected * (1 - expected) / kRays);
    EXPECT_NEAR(passed / kRays, expected, error);
    EXPECT_NEAR(sum / kRays, expected, error);
  }
}

}  // namespace
}  // namespace emberline
