// Tests which pixels the refinement tree requests for synthetic pictures, and why. The seeds are
// fixed, so failures are reproducible.
#include "renderer/drivers/adaptive/refinement_tree.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <set>

#include "renderer/core/errors.h"
#include "unit/refinement_pictures.h"
#include "unit/sample_statistics.h"

namespace emberline {
namespace {

// The pixels of each leaf form a rectangle that contains the leaf's sample. The areas of the leaves
// add up to the area of the crop.
void expect_leaves_tile(const RefinementTree& tree) {
  std::vector<int64_t> area(tree.sample_count(), 0);
  const Rect& w = tree.crop();
  for (int y = w.y0; y < w.y1; ++y) {
    for (int x = w.x0; x < w.x1; ++x) {
      const uint32_t leaf = tree.leaf_at(x, y);
      ASSERT_LT(leaf, area.size());
      ++area[leaf];
    }
  }
  int64_t sum = 0;
  const std::vector<Rect> rects = leaf_rects(tree);
  for (uint32_t i = 0; i < area.size(); ++i) {
    const Vec2i pixel = tree.sampled_pixel(i);
    ASSERT_EQ(area[i], rects[i].area());
    ASSERT_TRUE(rects[i].contains(pixel.x, pixel.y));
    sum += area[i];
  }
  ASSERT_EQ(sum, w.area());
}

TEST(RefinementTree, LeavesTileTheWindow) {
  for (const Rect& crop : awkward_windows()) {
    SCOPED_TRACE(name_of(crop));
    RefinementTree tree(crop, {.seed = 1});
    while (!tree.finished()) {
      insert_round(tree, noise, 7 + 11 * tree.rounds());
      ASSERT_NO_FATAL_FAILURE(expect_leaves_tile(tree));
    }
  }
}

TEST(RefinementTree, EveryPixelIsWantedOnceAndKeepsItsValue) {
  for (const Rect& crop : awkward_windows()) {
    for (const Picture& picture : {Picture(noise), constant_picture(Rgb(0.5f))}) {
      SCOPED_TRACE(name_of(crop));
      RefinementTree tree(crop, {.seed = 2});
      std::set<std::pair<int, int>> seen;
      while (!tree.finished()) {
        for (const Vec2i& pixel : insert_round(tree, picture)) {
          ASSERT_TRUE(crop.contains(pixel.x, pixel.y)) << pixel;
          ASSERT_TRUE(seen.insert({pixel.x, pixel.y}).second) << pixel << " twice";
        }
      }
      EXPECT_EQ(int64_t(seen.size()), crop.area());
      EXPECT_EQ(tree.open_count(), 0u);
      EXPECT_TRUE(tree.next_round().empty());
      for (int y = crop.y0; y < crop.y1; ++y) {
        for (int x = crop.x0; x < crop.x1; ++x) {
          ASSERT_EQ(tree.value(tree.leaf_at(x, y)), picture(x, y));
        }
      }
    }
  }
}

TEST(RefinementTree, AnEmptyWindowIsFinished) {
  RefinementTree tree(Rect{}, {});
  EXPECT_TRUE(tree.finished());
  EXPECT_TRUE(tree.next_round().empty());
}

TEST(RefinementTree, FramesTooLargeAreRefused) {
  EXPECT_THROW(RefinementTree(Rect{0, 0, 65537, 1}, {}), UsageError);
  EXPECT_THROW(RefinementTree(Rect{0, 0, 1, 65537}, {}), UsageError);
  EXPECT_THROW(RefinementTree(Rect{0, 0, 65536, 65536}, {}), UsageError);
  RefinementTree tree(Rect{0, 0, 65536, 1}, {});
  refine(tree, constant_picture(Rgb(1.0f)));
  EXPECT_EQ(tree.sample_count(), 65536u);
}

// The ratio of the largest leaf area to the smallest.
double area_ratio(const RefinementTree& tree, int64_t* smallest = nullptr) {
  int64_t low = tree.crop().area(), high = 0;
  for (const Rect& rect : leaf_rects(tree)) {
    low = std::min(low, rect.area());
    high = std::max(high, rect.area());
  }
  if (smallest) *smallest = low;
  return double(high) / double(low);
}

// Without contrast the tree only covers the frame. After any number of samples, the leaves are as
// equal in size as halving allows. The halves of an odd side differ by a pixel, and these
// differences add up. While leaves have at least 16 pixels, the largest is less than three times
// the smallest.
TEST(RefinementTree, AConstantPictureIsCoveredEvenly) {
  for (const size_t limit : {size_t(37), size_t(500), ~size_t(0)}) {
    RefinementTree tree({0, 0, 128, 128}, {.seed = 3});
    while (!tree.finished()) {
      insert_round(tree, constant_picture(Rgb(0.3f)), limit);
      ASSERT_LE(area_ratio(tree), 2) << tree.sample_count() << " samples, limit " << limit;
    }
    RefinementTree odd({0, 0, 131, 103}, {.seed = 3});
    int64_t smallest = 16;
    while (smallest >= 16) {
      insert_round(odd, constant_picture(Rgb(0.3f)), limit);
      const double ratio = area_ratio(odd, &smallest);
      if (smallest >= 16) {
        ASSERT_LT(ratio, 3) << odd.sample_count() << " samples, limit " << limit;
      }
    }
  }
}

// Equal leaves are ordered by a hash, not by tree order or age. 48 of 64 equal leaves are taken,
// and half of these should come from the left half of the frame. Their number is hypergeometric
// with a standard deviation of 1.75. The tolerance is 4 deviations, a false alarm for 6e-5 of all
// seeds.
TEST(RefinementTree, EqualsAreTakenFromAllOverTheFrame) {
  for (const uint32_t seed : {0u, 1u, 2u}) {
    RefinementTree tree({0, 0, 256, 256}, {.seed = seed});
    refine(tree, constant_picture(Rgb(0.3f)), 64);
    int left = 0;
    for (const Vec2i& pixel : insert_round(tree, constant_picture(Rgb(0.3f)), 48)) {
      left += pixel.x < 128;
    }
    EXPECT_NEAR(left, 24, 7) << "seed " << seed;
  }
}

// A coverage round splits all leaves that are too large and no others, whatever their contrast. In
// the second crop, leaves of both kinds are next to each other.
TEST(RefinementTree, CoversBeforeItLooksForFeatures) {
  // At the depth of 211 x 197 / 512 = 81.2 pixels per leaf, some leaves are too large and others
  // are not.
  for (const auto& [crop, limit] :
       {std::pair(Rect{0, 0, 256, 256}, 100), std::pair(Rect{0, 0, 211, 197}, 81)}) {
    RefinementTree tree(crop, {.seed = 4, .coverage_area = limit});
    while (tree.phase() == RefinementPhase::kCoverage) {
      const size_t before = tree.sample_count();
      const std::vector<Rect> rects = leaf_rects(tree);
      insert_round(tree, noise);
      const std::vector<Rect> now = leaf_rects(tree);
      for (uint32_t i = 0; i < before; ++i) {
        EXPECT_EQ(now[i].area() < rects[i].area(), rects[i].area() > limit) << rects[i].area();
      }
    }
    EXPECT_EQ(tree.phase(), RefinementPhase::kFeatures);
    if (crop.width() == 256) {
      EXPECT_EQ(tree.sample_count(), 1024u);  // 64 pixels each: the first power of two below 100
    }
  }
}

TEST(RefinementTree, PhasesFollowThePicture) {
  RefinementTree flat({0, 0, 64, 64}, {.seed = 5});
  refine(flat, constant_picture(Rgb(0.4f)), 16);
  EXPECT_EQ(flat.phase(), RefinementPhase::kPixelLevel);  // no contrast
  RefinementTree half({0, 0, 64, 64}, {.seed = 5});
  const Picture step = [](int x, int) { return Rgb(x < 32 ? 0.1f : 0.5f); };
  refine(half, step, 16);
  EXPECT_EQ(half.phase(), RefinementPhase::kFeatures);
  refine(half, step);
  EXPECT_EQ(half.phase(), RefinementPhase::kFinished);
  EXPECT_EQ(refinement_phase_name(half.phase()), "finished");
  // There are 16 leaves, with a step of d between the two middle columns. The leaves beside the
  // step and at the border of the frame have the largest variance, d^2 / 4, because one of four
  // values differs. tau is (2 / 255)^2.
  for (const auto& [steps, phase] : {std::pair(3.9f, RefinementPhase::kPixelLevel),
                                     std::pair(4.1f, RefinementPhase::kFeatures)}) {
    const Picture faint = [steps = steps](int x, int) {
      const float d = x < 32 ? 0.5f : 0.5f + steps / 255;
      return Rgb(d * d / (1 - d * d));  // shown as d
    };
    RefinementTree tree({0, 0, 64, 64}, {.seed = 5});
    refine(tree, faint, 16);
    EXPECT_EQ(tree.phase(), phase) << steps;
  }
}

TEST(RefinementTree, RoundsHaveTheirSizeAndTheirLimit) {
  RefinementTree tree({0, 0, 256, 256}, {.seed = 6});
  EXPECT_TRUE(tree.next_round(0).empty());
  tree.insert({});
  EXPECT_EQ(tree.rounds(), 0u);
  size_t expected = 1;
  for (; expected < 512; expected *= 2) {  // in the coverage phase, all leaves are split
    EXPECT_EQ(insert_round(tree, test_picture).size(), std::max<size_t>(1, expected / 2));
    EXPECT_EQ(tree.sample_count(), expected);
  }
  EXPECT_EQ(insert_round(tree, test_picture, 3).size(), 3u);
  int by_priority = 0;
  while (!tree.finished()) {
    const size_t open = tree.open_count(), samples = tree.sample_count();
    const std::vector<RefinementNode> leaves = tree.most_urgent(open);
    double total = 0, chosen = 0;
    for (const RefinementNode& leaf : leaves) total += double(leaf.priority);
    const size_t size = insert_round(tree, test_picture).size();
    for (size_t i = 0; i < size; ++i) chosen += double(leaves[i].priority);
    const size_t smallest = std::min(open, std::max({size_t(64), open / 16, samples / 64}));
    EXPECT_GE(size, smallest);
    EXPECT_LE(size, std::max(smallest, open / 4));
    if (size > smallest && size < open / 4) {
      ++by_priority;
      // Priorities within one bucket differ by up to an eighth and count as equal.
      EXPECT_NEAR(chosen, 0.25 * total, 0.02 * total);
    }
  }
  EXPECT_GT(by_priority, 5);
}

// Neighbours in the list are neighbours in the frame, so that rays and film accesses stay coherent.
// The mean step is a few leaves wide. In a random order it would be .52 of the frame's side, or 133
// pixels.
TEST(RefinementTree, PixelsAreListedInTheOrderOfTheTree) {
  RefinementTree tree({0, 0, 256, 256}, {.seed = 7});
  refine(tree, test_picture, 4096);
  const std::vector<Vec2i> pixels = insert_round(tree, test_picture);
  double sum = 0;
  for (size_t i = 1; i < pixels.size(); ++i) {
    const Vec2i step = pixels[i] - pixels[i - 1];
    sum += std::hypot(step.x, step.y);
  }
  EXPECT_LT(sum / double(pixels.size() - 1), 25);
}

TEST(RefinementTree, LimitSelectsTheBest) {
  RefinementTree tree({0, 0, 256, 256}, {.seed = 8});
  refine(tree, test_picture, 1500);
  const std::vector<RefinementNode> best = tree.most_urgent(20);
  const std::vector<Vec2i> pixels = insert_round(tree, test_picture, 20);
  ASSERT_EQ(best.size(), 20u);
  for (const RefinementNode& leaf : best) {
    EXPECT_TRUE(std::ranges::any_of(pixels, [&](const Vec2i& p) {
      return leaf.rect.contains(p.x, p.y);
    })) << name_of(leaf.rect);
  }
}

// The pixel of a new cell is uniform over the cell. Here the cell is the root with 8 x 6 pixels,
// for 48,000 seeds. The chi-square test has a false-alarm rate of 1e-6.
TEST(RefinementTree, PixelsAreDrawnUniformly) {
  std::vector<uint32_t> counts(48, 0);
  for (uint32_t seed = 0; seed < 48000; ++seed) {
    RefinementTree tree({0, 0, 8, 6}, {.seed = seed});
    const Vec2i pixel = tree.next_round()[0];
    ++counts[size_t(pixel.y * 8 + pixel.x)];
  }
  EXPECT_LT(chi_square(counts), chi_square_limit(47)) << "seeds 0 to 47999 again";
}

// The path to a pixel leads down from the crop. Each node is a half of the node before it and has
// the mean of its own samples, and the rounds increase.
TEST(RefinementTree, DescribesThePathToAPixel) {
  const Rect crop = {3, 5, 104, 76};
  RefinementTree tree(crop, {.seed = 11});
  EXPECT_TRUE(tree.describe(50, 50).empty());
  refine(tree, noise, 3000);
  for (const Vec2i& p : {Vec2i(3, 5), Vec2i(103, 75), Vec2i(50, 40)}) {
    const std::vector<RefinementNode> path = tree.describe(p.x, p.y);
    ASSERT_GE(path.size(), 2u);
    EXPECT_EQ(path[0].rect, crop);
    for (size_t i = 0; i < path.size(); ++i) {
      const RefinementNode& node = path[i];
      EXPECT_TRUE(node.rect.contains(p.x, p.y));
      EXPECT_EQ(node.leaf, i + 1 == path.size());
      Vec3d sum(0.0);
      for (int y = node.rect.y0; y < node.rect.y1; ++y) {
        for (int x = node.rect.x0; x < node.rect.x1; ++x) {
          sum += to_double(tree.value(tree.leaf_at(x, y)));
        }
      }
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(node.mean[c], sum[c] / double(node.rect.area()), 1e-5);
      if (node.leaf) continue;
      const Rect& half = path[i + 1].rect;
      EXPECT_NEAR(double(half.area()), double(node.rect.area()) / 2,
                  0.5 * std::max(half.width(), half.height()));
      EXPECT_EQ(half.intersect(node.rect), half);
      EXPECT_GT(path[i + 1].round, node.round);
      EXPECT_EQ(node.phase == RefinementPhase::kCoverage, node.rect.area() > 256);
      EXPECT_NEAR(node.priority,
                  double(node.rect.area()) * (std::max(node.v_int, node.v_ext) + 1e-3),
                  1e-5 * node.priority);
    }
    const RefinementNode& leaf = path.back();
    EXPECT_EQ(leaf.rect, leaf_rects(tree)[tree.leaf_at(p.x, p.y)]);
    EXPECT_EQ(leaf.round, tree.rounds());
  }
  const std::vector<Rect> rects = leaf_rects(tree);
  for (uint32_t i = 0; i < tree.sample_count(); ++i) {
    const Vec2i pixel = tree.sampled_pixel(i);
    const RefinementPhase phase = tree.describe(pixel.x, pixel.y).back().phase;
    ASSERT_EQ(phase == RefinementPhase::kFinished, rects[i].area() == 1);
  }
  refine(tree, noise);
  const RefinementNode pixel = tree.describe(50, 40).back();
  EXPECT_EQ(pixel.rect, (Rect{50, 40, 51, 41}));
  EXPECT_EQ(pixel.mean, noise(50, 40));
  EXPECT_EQ(pixel.phase, RefinementPhase::kFinished);
  EXPECT_EQ(pixel.priority, 0);
}

// The path describes a node as it was as a leaf, in the round before it was split.
TEST(RefinementTree, RecordsWhyALeafWasSplit) {
  RefinementTree tree({0, 0, 128, 128}, {.seed = 12});
  refine(tree, test_picture, 400);
  const RefinementNode before = tree.most_urgent(1)[0];
  const uint32_t round = tree.rounds();
  insert_round(tree, test_picture);
  refine(tree, test_picture, 3000);
  bool found = false;
  for (const RefinementNode& node : tree.describe(before.rect.x0, before.rect.y0)) {
    if (node.rect != before.rect) continue;
    found = true;
    EXPECT_FALSE(node.leaf);
    EXPECT_EQ(node.v_int, before.v_int);
    EXPECT_EQ(node.v_ext, before.v_ext);
    EXPECT_EQ(node.priority, before.priority);
    EXPECT_EQ(node.phase, RefinementPhase::kFeatures);
    EXPECT_EQ(node.round, round);
  }
  EXPECT_TRUE(found);
}

TEST(RefinementTree, TheSameForAnyNumberOfThreads) {
  std::vector<std::vector<Vec2i>> runs;
  for (const size_t threads : {1, 2, 8}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    RefinementTree tree({0, 0, 199, 211}, {.seed = 13});
    std::vector<Vec2i>& pixels = runs.emplace_back();
    while (!tree.finished()) {
      for (const Vec2i& pixel : insert_round(tree, test_picture)) pixels.push_back(pixel);
    }
  }
  EXPECT_EQ(runs[0], runs[1]);
  EXPECT_EQ(runs[0], runs[2]);
}

TEST(RefinementTree, TheSeedChoosesThePixels) {
  std::set<std::vector<int>> sets;
  for (const uint32_t seed : {0u, 1u, 2u, 0u}) {
    RefinementTree tree({0, 0, 64, 64}, {.seed = seed});
    refine(tree, constant_picture(Rgb(0.5f)), 64);
    std::vector<int> pixels;
    for (uint32_t i = 0; i < 64; ++i) {
      pixels.push_back(64 * tree.sampled_pixel(i).y + tree.sampled_pixel(i).x);
    }
    sets.insert(pixels);
  }
  EXPECT_EQ(sets.size(), 3u);
}

// A leaf that can be split takes 72 bytes together with the split that created it. The root has no
// such split.
TEST(RefinementTree, ThirtySixBytesPerNode) {
  for (const Picture& picture : {Picture(test_picture), constant_picture(Rgb(0.5f))}) {
    RefinementTree tree({0, 0, 256, 256}, {.seed = 16});
    while (!tree.finished()) {
      insert_round(tree, picture);
      const size_t nodes = 2 * tree.sample_count() - 1;
      ASSERT_LE(tree.node_bytes(), 36 * nodes + 16) << tree.sample_count() << " samples";
    }
    EXPECT_EQ(tree.map_bytes(), 4u * 256 * 256);
    EXPECT_LE(tree.node_bytes(), 22u * 2 * 256 * 256) << "finished: none can be split";
  }
}

TEST(RefinementTree, CountsLeavesByArea) {
  RefinementTree tree({0, 0, 61, 47}, {.seed = 17});
  EXPECT_TRUE(tree.leaves_by_area().empty());
  while (!tree.finished()) {
    insert_round(tree, noise);
    std::vector<size_t> expected;
    for (const Rect& rect : leaf_rects(tree)) {
      const auto log2 = size_t(std::log2(double(rect.area())));
      expected.resize(std::max(expected.size(), log2 + 1));
      ++expected[log2];
    }
    ASSERT_EQ(tree.leaves_by_area(), expected);
  }
}

}  // namespace
}  // namespace emberline
