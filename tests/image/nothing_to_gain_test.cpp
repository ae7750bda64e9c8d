// Where no pixel needs more samples than another, adaptive sampling should cost nothing.
#include <gtest/gtest.h>

#include "image/lit_floor.h"
#include "image/picture_error.h"

namespace emberline {
namespace {

using namespace test;

class NothingToGain : public testing::TestWithParam<uint32_t> {};

// Most pixels are the uniform frame's own, so the ratio is surer than either error.
TEST_P(NothingToGain, NestedLosesLessThanThreePerCent) {
  const auto scene = lit_floor();
  const CameraDescription view = lit_floor_view();
  RenderSettings s = lit_floor_settings();
  const References references = render_references(*scene, view, s, 4096);
  double uniform = 0, adaptive = 0, samples = 0;
  constexpr int kSeeds = 4;
  for (int seed = 0; seed < kSeeds; ++seed) {
    s.seed = uint32_t(seed);
    s.driver = "bucket";
    s.spp = GetParam();
    const RenderedImage even = render(*scene, view, s);
    uniform += squared_display_error(even, references, even.window);
    s.driver = "adaptive";
    s.adaptive.estimator = "nested";
    s.adaptive.budget = GetParam();
    const RenderedImage image = render(*scene, view, s);
    adaptive += squared_display_error(image, references, image.window);
    samples += double(image.counters.samples) / (s.width * s.height * kSeeds);
  }
  const double ratio = adaptive / uniform * samples / GetParam();
  std::printf("  squared error times samples, over that of uniform sampling: %.3f\n", ratio);
  EXPECT_LT(ratio, 1.03);
  EXPECT_GT(ratio, 0.9);
}
INSTANTIATE_TEST_SUITE_P(Budget, NothingToGain, testing::Values(16u, 32u, 48u, 128u));

}  // namespace
}  // namespace emberline
