// Tests the order of bisection, without rendering.
#include <gtest/gtest.h>

#include <deque>
#include <set>

#include "renderer/core/errors.h"
#include "renderer/drivers/bisection_driver.h"
#include "renderer/drivers/bisection_schedule.h"

namespace emberline {
namespace {

const Rect kWindows[] = {{0, 0, 1, 1},   {0, 0, 1, 97},    {3, 5, 98, 6},
                         {0, 0, 64, 64}, {5, 9, 118, 40},  {0, 0, 101, 103},
                         {0, 0, 2, 3},   {7, 1, 327, 181}, {0, 0, 37, 29}};

struct Line {
  int line;
  size_t level;
};

// Follows the paper's algorithm literally, one interval after another.
std::vector<Line> naive_order(int size) {
  struct Interval {
    int begin, end;
    size_t level;
  };
  std::vector<Line> order;
  std::deque<Interval> queue{{0, size, 0}};
  while (!queue.empty()) {
    const auto [a, b, level] = queue.front();
    queue.pop_front();
    const int m = (a + b) / 2;
    order.push_back({m, level});
    if (m > a) queue.push_back({a, m, level + 1});
    if (b > m + 1) queue.push_back({m + 1, b, level + 1});
  }
  return order;
}

TEST(BisectionOrder, MatchesThePaper) {
  using Levels = std::vector<std::vector<int>>;
  EXPECT_EQ(bisection_levels(7), (Levels{{3}, {1, 5}, {0, 2, 4, 6}}));
  EXPECT_EQ(bisection_levels(4), (Levels{{2}, {1, 3}, {0}}));
  EXPECT_TRUE(bisection_levels(0).empty());
  for (const int size : {1, 2, 3, 5, 16, 97, 720, 1280, 1009, 65536}) {
    const Levels levels = bisection_levels(size);
    const std::vector<Line> naive = naive_order(size);
    size_t i = 0;
    for (size_t level = 0; level < levels.size(); ++level) {
      for (const int line : levels[level]) {
        ASSERT_LT(i, naive.size()) << size;
        ASSERT_EQ(line, naive[i].line) << size << ", line number " << i;
        ASSERT_EQ(level, naive[i].level) << size << ", line number " << i;
        ++i;
      }
    }
    EXPECT_EQ(i, size_t(size));
  }
}

// A level adds at most one line between two lines of earlier levels. The display relies on this.
TEST(BisectionOrder, AddsAtMostOneLineBetweenTwo) {
  for (const int size : {2, 7, 29, 720, 1280, 1009}) {
    std::set<int> old;
    for (const std::vector<int>& level : bisection_levels(size)) {
      std::set<int> gaps;
      for (const int line : level) {
        const auto above = old.lower_bound(line);
        EXPECT_TRUE(gaps.insert(above == old.end() ? size : *above).second)
            << size << ", line " << line;
      }
      old.insert(level.begin(), level.end());
    }
  }
}

class BisectionScheduleOf : public testing::TestWithParam<BisectionAxis> {
 protected:
  // Calls check(pass, pixels of the crop) for the passes of 300 samples over each crop.
  template <typename Check>
  void for_each_pass(const Check& check) const {
    for (const Rect& crop : kWindows) {
      const auto steps = bisection_steps(crop.width(), crop.height(), GetParam());
      const auto pixels = uint64_t(crop.area());
      for (const SampleRange& samples : bisection_passes(300)) {
        check(BisectionPass(steps, crop, samples, PartShape::kSquare,
                            bisection_part_pixels(samples, pixels)),
              pixels);
        if (HasFatalFailure()) return;
      }
    }
  }
};

TEST_P(BisectionScheduleOf, StepsCoverEveryPixelOnce) {
  for (const Rect& crop : kWindows) {
    for (const BisectionCell& cell : {BisectionCell{1, 1}, {4, 2}, {32, 32}}) {
      const auto steps = bisection_steps(crop.width(), crop.height(), GetParam(), cell);
      std::vector<int> step_of(size_t(crop.area()), -1);
      for (size_t s = 0; s < steps.size(); ++s) {
        EXPECT_TRUE(std::ranges::is_sorted(steps[s].complete.columns));
        EXPECT_TRUE(std::ranges::is_sorted(steps[s].complete.rows));
        for (const int y : steps[s].added.rows) {
          for (const int x : steps[s].added.columns) {
            ASSERT_TRUE(x >= 0 && y >= 0 && x < crop.width() && y < crop.height());
            int& of = step_of[size_t(y) * size_t(crop.width()) + size_t(x)];
            ASSERT_EQ(of, -1) << x << "," << y << " twice";
            of = int(s);
          }
        }
        // After the step, exactly the lattice `complete` has been sampled.
        size_t there = 0;
        for (const int of : step_of) there += of >= 0;
        ASSERT_EQ(there, steps[s].complete.pixels());
        for (const int y : steps[s].complete.rows) {
          for (const int x : steps[s].complete.columns) {
            ASSERT_GE(step_of[size_t(y) * size_t(crop.width()) + size_t(x)], 0);
          }
        }
      }
      EXPECT_EQ(std::ranges::count(step_of, -1), 0);
    }
  }
  EXPECT_TRUE(bisection_steps(0, 5, GetParam()).empty());
}

struct Cut {
  PartShape shape;
  bool cells;  // cells are as large as a part
  uint64_t part_pixels;
};
constexpr Cut kCuts[] = {{PartShape::kRow, false, 1},    {PartShape::kRow, false, 16},
                         {PartShape::kColumn, false, 8}, {PartShape::kSquare, false, 128},
                         {PartShape::kSquare, true, 1},  {PartShape::kSquare, true, 2},
                         {PartShape::kSquare, true, 64}, {PartShape::kSquare, true, 1024}};

TEST_P(BisectionScheduleOf, PassesCoverEveryPixelOnceInTheOrderOfTheSteps) {
  for (const Rect& crop : kWindows) {
    for (const auto& [shape, cells, part_pixels] : kCuts) {
      const auto steps = bisection_steps(crop.width(), crop.height(), GetParam(),
                                         cells ? square_cell(part_pixels) : BisectionCell{});
      const SampleRange samples{4, 4};
      const BisectionPass pass(steps, crop, samples, shape, part_pixels);
      std::vector<int> hits(size_t(crop.area()), 0);
      std::vector<PixelWork> list;
      for (size_t part = 0; part < pass.parts(); ++part) {
        list.clear();
        pass.expand(part, list);
        ASSERT_FALSE(list.empty());
        ASSERT_EQ(list.size(), pass.pixels(part));
        ASSERT_LE(list.size(), part_pixels);
        const size_t step = pass.step_of(part);
        ASSERT_GE(part, pass.first_part(step));
        ASSERT_LT(part, pass.first_part(step + 1));
        const PixelLattice& added = steps[step].added;
        for (const PixelWork& work : list) {
          ASSERT_TRUE(crop.contains(work.x, work.y));
          ASSERT_TRUE(std::ranges::binary_search(added.columns, work.x - crop.x0));
          ASSERT_TRUE(std::ranges::binary_search(added.rows, work.y - crop.y0));
          ASSERT_EQ(work.first_sample, 4u);
          ASSERT_EQ(work.sample_count, 4u);
          hits[size_t(work.y - crop.y0) * size_t(crop.width()) + size_t(work.x - crop.x0)]++;
        }
      }
      for (const int h : hits) ASSERT_EQ(h, 1);
    }
  }
}

TEST_P(BisectionScheduleOf, RoundsAreShortAtFirst) {
  for_each_pass([](const BisectionPass& pass, uint64_t pixels) {
    for (size_t begin = 0, end; begin < pass.parts(); begin = end) {
      end = bisection_round_end(pass, begin, pixels);
      ASSERT_GT(end, begin);
      ASSERT_LE(end, pass.parts());
      if (pass.samples().first_sample > 0) {
        ASSERT_EQ(end, pass.parts()) << "later passes are a round each";
        continue;
      }
      ASSERT_EQ(pass.step_of(begin), pass.step_of(end - 1));
      uint64_t in_round = 0;
      for (size_t part = begin; part < end; ++part) in_round += pass.pixels(part);
      ASSERT_TRUE(end == begin + 1 || in_round <= pixels / 100) << in_round;
    }
  });
}

INSTANTIATE_TEST_SUITE_P(EveryAxis, BisectionScheduleOf,
                         testing::Values(BisectionAxis::kRows, BisectionAxis::kColumns,
                                         BisectionAxis::kBoth),
                         [](const auto& p) {
                           return std::string(name_of(bisection_axis_table(), p.param));
                         });

// In the worked example of 4 x 2 pixels, the columns come as {2} {1 3} {0} and the rows as {1} {0}.
TEST(BisectionSteps, BothAxesInTurn) {
  const auto steps = bisection_steps(4, 2, BisectionAxis::kBoth);
  const auto is = [](const PixelLattice& lattice, std::vector<int> columns, std::vector<int> rows) {
    return lattice.columns == columns && lattice.rows == rows;
  };
  ASSERT_EQ(steps.size(), 4u);
  EXPECT_TRUE(is(steps[0].added, {2}, {1}));
  EXPECT_TRUE(is(steps[1].added, {1, 3}, {1}));  // gaps of 2 and 1
  EXPECT_TRUE(is(steps[2].added, {0}, {1}));     // gaps of 1 and 1: columns first
  EXPECT_TRUE(is(steps[3].added, {0, 1, 2, 3}, {0}));
  EXPECT_TRUE(is(steps[2].complete, {0, 1, 2, 3}, {1}));
}

// A later pass bisects a grid of cells, with one cell per part, so that a part's pixels are
// neighbours.
TEST(BisectionSteps, CellsStayTogether) {
  const Rect crop{0, 0, 70, 45};
  const BisectionCell cell = square_cell(128);
  EXPECT_EQ(cell.width, 16);
  EXPECT_EQ(cell.height, 8);
  for (const auto& axis : bisection_axis_table()) {
    const auto steps = bisection_steps(70, 45, axis.value, cell);
    const BisectionPass pass(steps, crop, {8, 8}, PartShape::kSquare, 128);
    std::vector<PixelWork> list;
    for (size_t part = 0; part < pass.parts(); ++part) {
      list.clear();
      pass.expand(part, list);
      // The partial cells of the last row are drawn together.
      if (list.front().y >= 40) continue;
      for (const PixelWork& work : list) {
        EXPECT_EQ(work.x / cell.width, list.front().x / cell.width) << axis.name;
        EXPECT_EQ(work.y / cell.height, list.front().y / cell.height) << axis.name;
      }
    }
  }
}

// The gaps along one axis are at most about twice as long as the gaps along the other axis, so that
// early samples are spread evenly.
TEST(BisectionSteps, BothAxesKeepTheirGapsAlike) {
  const auto longest_gap = [](const std::vector<int>& lines, int size) {
    int before = -1, gap = 0;
    for (const int line : lines) {
      gap = std::max(gap, line - before);
      before = line;
    }
    return std::max(gap, size - before);
  };
  for (const auto& [width, height] : {std::pair{1280, 720}, {512, 512}, {301, 1009}}) {
    const auto steps = bisection_steps(width, height, BisectionAxis::kBoth);
    for (size_t s = 2; s < steps.size(); ++s) {
      const double ratio = double(longest_gap(steps[s].complete.columns, width)) /
                           longest_gap(steps[s].complete.rows, height);
      if (std::min(steps[s].complete.columns.size(), steps[s].complete.rows.size()) < 2) continue;
      EXPECT_GE(ratio, 0.4) << width << "x" << height << " step " << s;
      EXPECT_LE(ratio, 2.5) << width << "x" << height << " step " << s;
    }
  }
}

TEST(BisectionPasses, DoubleTheSamples) {
  using Passes = std::vector<SampleRange>;
  EXPECT_EQ(bisection_passes(1), (Passes{{0, 1}}));
  EXPECT_EQ(bisection_passes(16), (Passes{{0, 1}, {1, 1}, {2, 2}, {4, 4}, {8, 8}}));
  EXPECT_EQ(bisection_passes(37),
            (Passes{{0, 1}, {1, 1}, {2, 2}, {4, 4}, {8, 8}, {16, 16}, {32, 5}}));
  EXPECT_EQ(bisection_passes(1u << 24).size(), 25u);
}

}  // namespace
}  // namespace emberline
