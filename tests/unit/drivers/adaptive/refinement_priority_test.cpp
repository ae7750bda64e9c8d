// Compares the contrast measure of the refinement tree with variances computed by hand, for any
// kind of radiance.
#include "renderer/drivers/adaptive/refinement_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "unit/refinement_pictures.h"

namespace emberline {
namespace {

// The display value sqrt(x / (1 + x)), as the header defines it.
double display(double radiance) {
  const double x = std::max(0.0, radiance);
  return std::sqrt(x / (1 + x));
}

// The variance of `values`, weighted over the channels as the header defines.
double weighed_variance(const std::vector<Rgb>& values, double exposure = 1) {
  const auto variance = [&](const std::function<double(const Rgb&)>& of) {
    double mean = 0, sum = 0;
    for (const Rgb& v : values) mean += of(v) / double(values.size());
    for (const Rgb& v : values) sum += (of(v) - mean) * (of(v) - mean);
    return values.size() > 1 ? sum / double(values.size() - 1) : 0.0;
  };
  double channels = 0;
  for (int c = 0; c < 3; ++c) {
    channels = std::max(channels, variance([&](const Rgb& v) { return display(exposure * v[c]); }));
  }
  return 0.5 *
         (channels + variance([&](const Rgb& v) { return display(exposure * luminance(v)); }));
}

// With two leaves, v_int and v_ext are both the variance of two values.
TEST(RefinementTree, VariancesOfTwoLeaves) {
  const std::vector<std::pair<Rgb, Rgb>> cases = {{Rgb(0.2f), Rgb(0.7f)},
                                                  {Rgb(0.0f), Rgb(0.0f, 0.0f, 1.0f)},
                                                  {Rgb(1.0f, 0.0f, 0.0f), Rgb(0.0f, 1.0f, 0.0f)},
                                                  {Rgb(-3.0f), Rgb(3e38f)}};
  for (const float exposure : {1.0f, 0.25f, 4.0f}) {
    for (const auto& [a, b] : cases) {
      RefinementTree tree({0, 0, 4, 2}, {.seed = 9, .exposure = exposure});
      refine(
          tree, [&, a = a, b = b](int x, int) { return x < 2 ? a : b; }, 2);
      const double v = weighed_variance({a, b}, exposure);
      for (const RefinementNode& leaf : tree.most_urgent(9)) {
        EXPECT_EQ(leaf.rect.area(), 4);
        EXPECT_NEAR(leaf.v_int, v, 1e-4 * v);
        EXPECT_NEAR(leaf.v_ext, v, 1e-4 * v);
        EXPECT_NEAR(leaf.priority, 4 * (v + 1e-3), 1e-4 * 4 * (v + 1e-3));
      }
    }
  }
}

// Compares v_ext with the variance of the leaves across the middle of each edge, which the test
// looks up directly. The leaves are inside the crop, at its borders and corners, and one pixel away
// from them.
TEST(RefinementTree, ExternalVarianceComesFromTheNeighbours) {
  std::set<size_t> neighbours_seen;
  for (const Rect& crop : {Rect{10, 20, 110, 97}, Rect{0, 0, 7, 7}, Rect{0, 0, 3, 5},
                           Rect{-2, -3, 4, 1}, Rect{0, 0, 1, 9}}) {
    SCOPED_TRACE(name_of(crop));
    RefinementTree tree(crop, {.seed = 10});
    while (!tree.finished()) {
      insert_round(tree, noise, 1 + size_t(crop.area()) / 10);
      for (const RefinementNode& leaf : tree.most_urgent(tree.open_count())) {
        if (leaf.priority == 0) continue;  // not split in this phase
        const Rect& r = leaf.rect;
        const int x = r.x0 + (r.width() - 1) / 2, y = r.y0 + (r.height() - 1) / 2;
        std::vector<Rgb> values = {leaf.mean};
        for (const Vec2i& p :
             {Vec2i(r.x0 - 1, y), Vec2i(r.x1, y), Vec2i(x, r.y0 - 1), Vec2i(x, r.y1)}) {
          if (crop.contains(p.x, p.y)) values.push_back(tree.value(tree.leaf_at(p.x, p.y)));
        }
        neighbours_seen.insert(values.size() - 1);
        // Shades are rounded to 2^-16.
        EXPECT_NEAR(leaf.v_ext, weighed_variance(values), 5e-5) << name_of(r);
        EXPECT_NEAR(leaf.priority, double(r.area()) * (std::max(leaf.v_int, leaf.v_ext) + 1e-3),
                    1e-5 * leaf.priority);
      }
    }
  }
  EXPECT_EQ(neighbours_seen, (std::set<size_t>{0, 1, 2, 3, 4}));
}

TEST(RefinementTree, NonFiniteValuesAreBlack) {
  const float nan = std::nanf(""), infinity = INFINITY;
  const Rgb bad[] = {Rgb(nan), Rgb(0.1f, infinity, 0.1f), Rgb(0.2f, 0.2f, -infinity),
                     Rgb(1.0f, 1.0f, nan)};
  const auto is_bad = [](int x, int y) { return noise(x, y).x < 0.1f; };
  const Picture poisoned = [&](int x, int y) {
    return is_bad(x, y) ? bad[(x + y) % 4] : test_picture(x, y);
  };
  const Picture black = [&](int x, int y) { return is_bad(x, y) ? Rgb(0.0f) : test_picture(x, y); };
  RefinementTree a({0, 0, 97, 89}, {.seed = 14}), b({0, 0, 97, 89}, {.seed = 14});
  while (!a.finished()) {
    ASSERT_EQ(insert_round(a, poisoned), insert_round(b, black));
    for (uint32_t i = 0; i < a.sample_count(); ++i) ASSERT_TRUE(is_finite(a.value(i)));
  }
}

TEST(RefinementTree, LightsOfAnyBrightnessKeepPrioritiesFinite) {
  const Picture bright = [](int x, int y) {
    const float kind = noise(x, y).x;
    return kind < 0.2f   ? Rgb(1e30f)
           : kind < 0.3f ? Rgb(3e38f, 0.0f, 3e38f)
           : kind < 0.4f ? Rgb(-1e30f)
                         : Rgb(0.3f);
  };
  for (const float exposure : {1e-6f, 1.0f, 1e6f}) {
    RefinementTree tree({0, 0, 97, 89}, {.seed = 15, .exposure = exposure});
    while (!tree.finished()) {
      insert_round(tree, bright);
      for (const RefinementNode& leaf : tree.most_urgent(97 * 89)) {
        ASSERT_GE(leaf.priority, 0);
        // The variance of values in [0, 1] is at most 1/2 for two values, and less for more values.
        ASSERT_LE(leaf.priority, 1.01 * double(leaf.rect.area()) * (0.5 + 1e-3));
      }
      ASSERT_TRUE(is_finite(tree.describe(0, 0)[0].mean));
    }
  }
}

}  // namespace
}  // namespace emberline
