// Compares the `variance` channel of a stratified frame with the frame's squared error.
#include <gtest/gtest.h>

#include "image/lit_floor.h"
#include "image/picture_error.h"
#include "support/long_tests.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kVarianceSeeds = 4;
constexpr size_t kVariance = 5;  // index of the channel, after R G B A samples

// Means over pixels, R, G, B and seeds.
struct ErrorMeasurement {
  double truth = 0, estimate = 0;
};

ErrorMeasurement measure(const Scene& scene, RenderSettings s, const References& references) {
  s.aovs = "variance";
  ErrorMeasurement found;
  const double terms = 3.0 * s.width * s.height * kVarianceSeeds;
  for (int seed = 0; seed < kVarianceSeeds; ++seed) {
    s.seed = uint32_t(seed);
    const RenderedImage image = render(scene, lit_floor_view(), s);
    for (int y = 0; y < s.height; ++y) {
      for (int x = 0; x < s.width; ++x) {
        for (size_t c = 0; c < 3; ++c) {
          const float* p = image.pixel(x, y);
          const double to_a = double(p[c]) - double(references.a.pixel(x, y)[c]);
          const double to_b = double(p[c]) - double(references.b.pixel(x, y)[c]);
          found.truth += to_a * to_b / terms;
          found.estimate += double(p[kVariance + c]) / terms;
        }
      }
    }
  }
  return found;
}

class VarianceChannel : public testing::Test {
 protected:
  ErrorMeasurement uniform(uint32_t spp) const {
    RenderSettings s = lit_floor_settings();
    s.spp = spp;
    return measure(*scene_, s, references_);
  }
  ErrorMeasurement nested(const AdaptiveSettings& adaptive) const {
    RenderSettings s = lit_floor_settings();
    s.driver = "adaptive";
    s.adaptive = adaptive;
    s.adaptive.estimator = "nested";
    return measure(*scene_, s, references_);
  }

  const std::unique_ptr<Scene> scene_ = lit_floor();
  const References references_ = render_references(*scene_, lit_floor_view(), lit_floor_settings(),
                                                   long_or_short(4096u, 1024u));
};

// If every pixel ends at n samples, the expectation of the halves' estimate is V(n/2) - V(n)
// (sample_halves.h). Uniform frames of n/2 and of n samples measure this value independently. The
// mean over 6144 pixels, each a square with one degree of freedom, has 3 % noise.
TEST_F(VarianceChannel, OfHalvesEqualsGainOfLastDoubling) {
  for (const uint32_t n : {32u, 128u}) {
    SCOPED_TRACE(n);
    const ErrorMeasurement half = uniform(n / 2), whole = uniform(n),
                           halves = nested({.max_samples = n});
    EXPECT_EQ(halves.truth, whole.truth) << "the same samples";
    const double expected = half.truth - whole.truth;
    std::printf("  told %.3g, V(n/2) - V(n) %.3g, V(n) %.3g; by the samples' spread %.3g\n",
                halves.estimate, expected, whole.truth, whole.estimate);
    EXPECT_NEAR(halves.estimate, expected, 0.15 * expected);
    EXPECT_GT(whole.estimate, 3 * whole.truth) << "no scene to tell the two by";
  }
}

// With a budget, the pixels end at different sample counts.
TEST_F(VarianceChannel, OfBudgetIsOneToTwoTimesTheTruth) {
  for (const uint32_t budget : {32u, 128u}) {
    SCOPED_TRACE(budget);
    const ErrorMeasurement found = nested({.budget = budget});
    std::printf("  told over true: %.2f\n", found.estimate / found.truth);
    EXPECT_GT(found.estimate, 1.0 * found.truth);
    EXPECT_LT(found.estimate, 2.0 * found.truth);
  }
}

}  // namespace
}  // namespace emberline
