// Compares the smooth picture of a refinement tree with its definition.
#include "renderer/drivers/adaptive/smooth_reconstruction.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdio>

#include "unit/refinement_pictures.h"

namespace emberline {
namespace {

// Gives every pixel the value of its leaf, which is Painter & Sloan's first reconstruction.
std::vector<Rgb> constant(const RefinementTree& tree) {
  std::vector<Rgb> picture;
  for (const uint32_t leaf : tree.leaf_map()) picture.push_back(tree.value(leaf));
  return picture;
}

std::vector<Rgb> smooth(const RefinementTree& tree) {
  std::vector<Rgb> picture(size_t(tree.crop().area()), Rgb(-1.0f));
  std::vector<Rgb> values;
  for (uint32_t leaf = 0; leaf < tree.sample_count(); ++leaf) values.push_back(tree.value(leaf));
  reconstruct_smooth(tree, values, picture);
  return picture;
}

double rmse(const std::vector<Rgb>& picture, int width, const Picture& reference) {
  double sum = 0;
  for (size_t i = 0; i < picture.size(); ++i) {
    sum += square(double(picture[i].x) - reference(int(i) % width, int(i) / width).x);
  }
  return std::sqrt(sum / double(picture.size()));
}

// A gently curved picture without noise or edges.
Rgb hills(int x, int y) {
  return Rgb(0.5f + 0.2f * std::sin(0.05f * float(x)) * std::cos(0.04f * float(y)));
}

TEST(SmoothReconstruction, SmoothGivesAConstantExactly) {
  const Rgb value(0.1f, 0.7f, 12.3f);
  for (const Rect& crop : awkward_windows()) {
    RefinementTree tree(crop, {.seed = 2});
    while (!tree.finished()) {
      insert_round(tree, constant_picture(value));
      for (const Rgb& pixel : smooth(tree)) ASSERT_EQ(pixel, value) << tree.sample_count();
    }
  }
}

TEST(SmoothReconstruction, SmoothEndsAsThePicture) {
  for (const Rect& crop : awkward_windows()) {
    RefinementTree tree(crop, {.seed = 3});
    refine(tree, test_picture);
    const std::vector<Rgb> picture = smooth(tree);
    size_t i = 0;
    for (int y = crop.y0; y < crop.y1; ++y) {
      for (int x = crop.x0; x < crop.x1; ++x) ASSERT_EQ(picture[i++], test_picture(x, y));
    }
  }
}

TEST(SmoothReconstruction, SmoothIsBlackBeforeTheFirstSample) {
  const RefinementTree tree({0, 0, 5, 4}, {});
  for (const Rgb& pixel : smooth(tree)) EXPECT_EQ(pixel, Rgb(0.0f));
  RefinementTree empty(Rect{}, {});
  EXPECT_TRUE(smooth(empty).empty());
}

// Samples keep their values. All other pixels lie between the samples' minimum and maximum, so none
// is black.
TEST(SmoothReconstruction, SmoothKeepsSamplesAndStaysBetweenThem) {
  RefinementTree tree({0, 0, 101, 103}, {.seed = 4});
  while (!tree.finished()) {
    insert_round(tree, hills);
    const std::vector<Rgb> picture = smooth(tree);
    float low = 1, high = 0;
    for (uint32_t i = 0; i < tree.sample_count(); ++i) {
      const Vec2i p = tree.sampled_pixel(i);
      ASSERT_EQ(picture[size_t(p.y * 101 + p.x)], tree.value(i));
      low = std::min(low, tree.value(i).x);
      high = std::max(high, tree.value(i).x);
    }
    for (const Rgb& pixel : picture) {
      ASSERT_GE(pixel.x, low - 1e-6f);
      ASSERT_LE(pixel.x, high + 1e-6f);
    }
  }
}

// Two of the 4 x 1 pixels are samples, one in each half. The hole next to the middle has three
// quarters of the value of its own half, and the outer hole has all of it.
TEST(SmoothReconstruction, SmoothIsBilinear) {
  int inner_holes = 0;
  for (uint32_t seed = 0; seed < 16; ++seed) {
    RefinementTree tree({0, 0, 4, 1}, {.seed = seed});
    refine(
        tree, [](int x, int) { return Rgb(x < 2 ? 1.0f : 5.0f); }, 2);
    std::vector<Rgb> expected = {Rgb(1.0f), Rgb(2.0f), Rgb(4.0f), Rgb(5.0f)};
    for (uint32_t i = 0; i < 2; ++i) {
      expected[size_t(tree.sampled_pixel(i).x)] = tree.value(i);
      inner_holes += tree.sampled_pixel(i).x % 3 == 0;
    }
    EXPECT_EQ(smooth(tree), expected) << "seed " << seed;
  }
  EXPECT_GT(inner_holes, 0);
}

double largest_step(const std::vector<Rgb>& picture, int width) {
  double largest = 0;
  for (size_t i = 0; i + 1 < picture.size(); ++i) {
    if (int(i + 1) % width != 0) {
      largest = std::max(largest, std::abs(double(picture[i + 1].x) - picture[i].x));
    }
  }
  return largest;
}

// On a picture without edges, the error and the steps are clearly smaller than with constant
// leaves.
TEST(SmoothReconstruction, SmoothIsSmooth) {
  RefinementTree tree({0, 0, 256, 256}, {.seed = 5});
  for (const size_t samples : {256, 2048, 16384}) {
    refine(tree, hills, samples);
    const std::vector<Rgb> leaves = constant(tree), interpolated = smooth(tree);
    EXPECT_LT(rmse(interpolated, 256, hills), 0.6 * rmse(leaves, 256, hills)) << samples;
    EXPECT_LT(largest_step(interpolated, 256), 0.8 * largest_step(leaves, 256)) << samples;
  }
}

// This is the intended use: the picture has edges, and its samples have noise of +-50 %, as from a
// path tracer. Without noise, the leaves reproduce edges better. tests/bench/results lists the
// errors.
TEST(SmoothReconstruction, SmoothAveragesNoise) {
  const Picture noisy = [](int x, int y) {
    const uint32_t h = hash_combine(hash32(uint32_t(x)), uint32_t(y));
    return test_picture(x, y) * (0.5f + to_unit_float(h));
  };
  struct Case {
    const char* name;
    Picture picture;
    double samples_per_pixel, most;  // `most` is the largest ratio of the errors
  };
  for (const Case& c :
       {Case{"without noise", test_picture, 0.0625, 1.2},
        Case{"without noise", test_picture, 0.25, 1.5}, Case{"with noise", noisy, 0.0625, 0.85},
        Case{"with noise", noisy, 0.25, 0.85}, Case{"with noise", noisy, 0.5, 0.92}}) {
    double leaves = 0, interpolated = 0;
    for (uint32_t seed = 0; seed < 8; ++seed) {
      RefinementTree tree({0, 0, 256, 256}, {.seed = seed});
      refine(tree, c.picture, size_t(c.samples_per_pixel * 65536));
      leaves += rmse(constant(tree), 256, test_picture) / 8;
      interpolated += rmse(smooth(tree), 256, test_picture) / 8;
    }
    EXPECT_LT(interpolated, c.most * leaves) << c.name << ", " << c.samples_per_pixel;
    std::printf("%s, %.4f samples per pixel: constant %.4f, smooth %.4f\n", c.name,
                c.samples_per_pixel, leaves, interpolated);
  }
}

TEST(SmoothReconstruction, SurviveLightsOfAnyBrightness) {
  RefinementTree tree({0, 0, 61, 43}, {.seed = 6});
  refine(
      tree, [](int x, int y) { return Rgb((x + y) % 3 == 0 ? 1e30f : 0.2f); }, 500);
  for (const Rgb& pixel : smooth(tree)) ASSERT_TRUE(is_finite(pixel));
}

TEST(SmoothReconstruction, SameBitsForAnyNumberOfThreads) {
  RefinementTree tree({0, 0, 201, 190}, {.seed = 7});
  refine(tree, test_picture, 5000);
  std::vector<std::vector<Rgb>> pictures;
  for (const size_t threads : {1, 8}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    pictures.push_back(smooth(tree));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

}  // namespace
}  // namespace emberline
