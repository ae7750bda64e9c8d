// The refinement tree puts samples where the picture needs them and so reduces the error. The seeds
// are fixed, so failures are reproducible.
#include "renderer/drivers/adaptive/refinement_tree.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "unit/refinement_pictures.h"

namespace emberline {
namespace {

// An isolated disc has 28 pixels in a frame of 256 x 256. If one of the first 2048 samples (one per
// 32 pixels) hits it, then after 4096 samples the disc and the pixels around it have ten times the
// sample density of the frame. If every pixel were sampled, the density would be 16 times as high.
// Equal leaves of 32 pixels hit the disc in 1 - (1 - 28/65536)^2048 = 58 % of the seeds. Fewer than
// 8 hits in 32 seeds occur once in 33,000 sets of seeds.
TEST(RefinementTree, ALoneDiscDrawsTheSamples) {
  const auto distance = [](int x, int y) { return std::hypot(x + 0.5 - 100.3, y + 0.5 - 77.8); };
  const Picture disc = [&](int x, int y) { return Rgb(distance(x, y) < 3 ? 1.0f : 0.0f); };
  int area = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) area += distance(x, y) < 4;
  }
  int hit = 0;
  for (uint32_t seed = 0; seed < 32; ++seed) {
    RefinementTree tree({0, 0, 256, 256}, {.seed = seed});
    refine(tree, disc, 2048);
    bool seen = false;
    for (uint32_t i = 0; i < 2048; ++i) seen |= tree.value(i).x > 0;
    if (!seen) continue;
    ++hit;
    refine(tree, disc, 4096);
    int inside = 0;
    for (uint32_t i = 0; i < 4096; ++i) {
      const Vec2i p = tree.sampled_pixel(i);
      inside += distance(p.x, p.y) < 4;
    }
    EXPECT_GE(double(inside) / area * 16, 10) << "seed " << seed;
  }
  EXPECT_GE(hit, 8);
}

double rmse(const RefinementTree& tree, const Picture& picture) {
  double sum = 0;
  const Rect& w = tree.crop();
  for (int y = w.y0; y < w.y1; ++y) {
    for (int x = w.x0; x < w.x1; ++x) {
      sum += square(double(tree.value(tree.leaf_at(x, y)).x - picture(x, y).x));
    }
  }
  return std::sqrt(sum / double(w.area()));
}

// Compares the tree with leaves of equal size, each with one random sample. Such leaves come from
// the same tree with a kappa so large that only size counts. The pictures are without noise, or
// have +-50 % on every sample. The errors are printed, and tests/bench/results lists them.
TEST(RefinementTree, TheErrorIsBelowThatOfEqualLeaves) {
  const Picture noisy = [](int x, int y) { return test_picture(x, y) * (0.5f + noise(x, y).x); };
  struct Case {
    const char* name;
    Picture picture;
    double samples_per_pixel, most;  // `most` is the largest ratio of the errors
  };
  for (const Case& c :
       {Case{"without noise", test_picture, 0.0625, 0.65},
        Case{"without noise", test_picture, 0.25, 0.4},
        Case{"without noise", test_picture, 0.5, 0.1}, Case{"with noise", noisy, 0.0625, 0.9},
        Case{"with noise", noisy, 0.25, 0.95}, Case{"with noise", noisy, 0.5, 0.95}}) {
    double refined = 0, equal = 0;
    for (uint32_t seed = 0; seed < 8; ++seed) {
      const auto samples = size_t(c.samples_per_pixel * 65536);
      RefinementTree adaptive({0, 0, 256, 256}, {.seed = seed});
      RefinementTree uniform({0, 0, 256, 256}, {.seed = seed, .coverage_weight = 1e6f});
      refine(adaptive, c.picture, samples);
      refine(uniform, c.picture, samples);
      refined += rmse(adaptive, test_picture) / 8;
      equal += rmse(uniform, test_picture) / 8;
    }
    EXPECT_LT(refined, c.most * equal) << c.samples_per_pixel << " samples per pixel";
    std::printf("%s, %.4f samples per pixel: %.4f, equal leaves %.4f\n", c.name,
                c.samples_per_pixel, refined, equal);
  }
}

}  // namespace
}  // namespace emberline
