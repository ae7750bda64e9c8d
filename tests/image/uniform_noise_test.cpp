// If all pixels need equally many samples, adaptive sampling should cost nothing.
#include <gtest/gtest.h>

#include "image/lit_floor.h"
#include "image/picture_error.h"
#include "support/long_tests.h"

namespace emberline {
namespace {

using namespace test;

// Most pixels equal those of the uniform frame, so the ratio of the two errors is more precise than
// either error.
TEST(UniformNoise, NestedIsAtMostThreePercentWorse) {
  const auto scene = lit_floor();
  const CameraDescription view = lit_floor_view();
  RenderSettings s = lit_floor_settings();
  const References references = render_references(*scene, view, s, long_or_short(4096u, 1024u));
  constexpr uint32_t kFrames = 4;
  for (const uint32_t budget : {16u, 32u, 48u, 128u}) {
    double uniform = 0, adaptive = 0, samples = 0;
    for (uint32_t seed = 0; seed < kFrames; ++seed) {
      s.seed = seed;
      s.driver = "bucket";
      s.spp = budget;
      const RenderedImage even = render(*scene, view, s);
      uniform += squared_display_error(even, references, even.crop);
      s.driver = "adaptive";
      s.adaptive.estimator = "nested";
      s.adaptive.budget = budget;
      const RenderedImage image = render(*scene, view, s);
      adaptive += squared_display_error(image, references, image.crop);
      samples += double(image.counters.samples) / (s.width * s.height * kFrames);
    }
    const double ratio = adaptive / uniform * samples / budget;
    std::printf("  squared error times samples, over that of uniform sampling: %.3f\n", ratio);
    EXPECT_LT(ratio, 1.03) << budget << " samples, seeds 0 to " << kFrames - 1;
    EXPECT_GT(ratio, 0.9) << budget << " samples, seeds 0 to " << kFrames - 1;
  }
}

}  // namespace
}  // namespace emberline
