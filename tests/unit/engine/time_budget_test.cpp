// Tests how `time-budget` plans work, with a clock that the tests set.
#include "renderer/engine/time_budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/engine/render_plan.h"

namespace emberline {
namespace {

// Renders with a pace that may depend on the work done so far. Returns the time at which the frame
// would end if it were not stopped, and the number of plans.
template <typename Pace>
std::pair<double, int> end_of_frame(double seconds, double pilot, const Pace& pace) {
  double now = 0, work = 0;
  const auto render = [&](double until) {
    for (constexpr int kSteps = 1000; work < until;) {
      const double step = std::min(until / kSteps, until - work);
      now += step * pace(work);
      work += step;
      if (until - work < 1e-9 * until) work = until;
    }
  };
  FrameBudget budget(
      seconds, [&] { return now; }, 0);
  render(pilot);
  int plans = 0;
  while (const std::optional<double> factor = budget.next_factor(work)) {
    ++plans;
    render(work * *factor);
  }
  return {now, plans};
}

// The frame is stopped at the end of the time, so it must not end before.
TEST(FrameBudget, FillsTheTimeAfterAPlanAndTwoCorrections) {
  for (const double seconds : {5.0, 60.0}) {
    for (const double slower : {0.7, 1.0, 1.4}) {
      const auto [end, plans] = end_of_frame(
          seconds, 1000, [&](double work) { return 1e-4 * (work < 1000 ? 1.5 : slower); });
      EXPECT_EQ(plans, 3) << slower;
      EXPECT_GE(end, seconds) << slower;
      EXPECT_LT(end, 1.15 * seconds) << slower;
    }
  }
}

TEST(FrameBudget, EndsAfterThePilotIfThatTookAllTheTime) {
  const auto [end, plans] = end_of_frame(1.0, 1e5, [](double) { return 1e-4; });
  EXPECT_EQ(plans, 0);
  EXPECT_NEAR(end, 10, 0.1);
}

TEST(FrameBudget, WithoutWorkThereIsNoPlan) {
  FrameBudget budget(
      1.0, [] { return 0.1; }, 0);
  EXPECT_FALSE(budget.next_factor(0));
}

// An earlier run may have done exactly what it had planned.
TEST(FrameBudget, AResumedFrameMeasuresThePaceAgain) {
  double now = 0;
  FrameBudget budget(
      10.0, [&] { return now; }, 1000);
  EXPECT_EQ(budget.next_factor(1000), 1.25);
  now = 0.25;
  EXPECT_NEAR(budget.next_factor(1250).value_or(0), 1 + (6 - 0.25) / (1250 * 1e-3), 1e-9);
}

TEST(FrameBudget, EndsIfNoWorkCanBeAdded) {
  FrameBudget budget(
      10.0, [] { return 0.0; }, 1000);
  EXPECT_TRUE(budget.next_factor(1000));
  EXPECT_FALSE(budget.next_factor(1000));
}

// Renders tiles with `workers` workers, each of which renders whole tiles. Returns the time of the
// end.
double end_of_tiles(double seconds, const std::vector<double>& costs, double predicted_pace,
                    double pace, size_t workers, std::vector<uint32_t>* counts = nullptr) {
  workers = std::min(workers, costs.size());
  double now = 0;
  TileBudget budget(
      seconds, [&] { return now; }, costs, predicted_pace, 1);
  struct Running {
    size_t tile;
    double end;
  };
  std::vector<Running> running;
  const auto finish_first = [&] {
    const auto first = std::ranges::min_element(running, {}, &Running::end);
    now = first->end;
    budget.end(first->tile);
    running.erase(first);
  };
  for (size_t i = 0; i < costs.size(); ++i) {
    if (running.size() == workers) finish_first();
    const uint32_t count = budget.begin(i);
    if (counts) counts->push_back(count);
    now += 1e-6;
    running.push_back({i, now + count * costs[i] * pace * double(workers)});
  }
  while (!running.empty()) finish_first();
  return now;
}

TEST(TileBudget, EndsOnTimeIfThePilotMisjudgedThePace) {
  std::vector<double> costs(200);
  for (size_t i = 0; i < costs.size(); ++i) costs[i] = 1 + std::sin(double(i)) / 2;
  for (const double misjudged : {0.5, 1.0, 2.0}) {
    for (const size_t workers : {size_t(1), size_t(4)}) {
      const double end = end_of_tiles(20, costs, 2e-3 * misjudged, 2e-3, workers);
      EXPECT_NEAR(end, 20, 0.6) << misjudged << ", " << workers;
    }
  }
}

// Many workers begin their first tiles at nearly the same time, when no pace is known.
TEST(TileBudget, EndsOnTimeWithNearlyAsManyWorkersAsTiles) {
  for (const size_t workers : {size_t(4), size_t(8), size_t(15), size_t(64)}) {
    std::vector<uint32_t> counts;
    const std::vector<double> costs(15, 1.0);
    const double end = end_of_tiles(10, costs, 1e-3, 1e-3, workers, &counts);
    EXPECT_LT(end, 15) << workers;
    EXPECT_LT(*std::ranges::max_element(counts), 1500u) << workers;
  }
}

// With few samples per pixel, counts differ by one, so that the frame still fits.
TEST(TileBudget, RoundsCountsUpAndDown) {
  const std::vector<double> costs(100, 1.0);
  std::vector<uint32_t> counts;
  EXPECT_NEAR(end_of_tiles(10, costs, 0.04, 0.04, 1, &counts), 10, 0.3);  // 2.5 samples
  EXPECT_EQ(*std::ranges::min_element(counts), 2u);
  EXPECT_EQ(*std::ranges::max_element(counts), 3u);
}

TEST(TileBudget, EveryTileGetsSamples) {
  std::vector<uint32_t> counts;
  end_of_tiles(1, std::vector<double>(10, 1.0), 1.0, 1.0, 1, &counts);
  EXPECT_EQ(counts, std::vector<uint32_t>(10, 1));
}

TEST(TileBudget, FirstTilesAreSpreadOverTheFrame) {
  for (const size_t count : {size_t(1), size_t(2), size_t(3), size_t(60), size_t(1000)}) {
    TileBudget budget(
        10, [] { return 0.0; }, std::vector<double>(count, 1.0), 0.1, 1);
    std::vector<size_t> tiles;
    for (size_t n = 0; n < count; ++n) tiles.push_back(budget.tile_at(n));
    std::vector<size_t> first(tiles.begin(), tiles.begin() + std::ptrdiff_t(count / 5));
    std::ranges::sort(first);
    if (count < 5) continue;
    const size_t limit = std::max<size_t>(10, count / 20);
    EXPECT_LE(first.front(), limit) << count;
    EXPECT_GE(first.back() + limit, count - 1) << count;
    for (size_t i = 1; i < first.size(); ++i) EXPECT_LE(first[i] - first[i - 1], limit) << count;
    std::ranges::sort(tiles);
    for (size_t i = 0; i < count; ++i) EXPECT_EQ(tiles[i], i) << count;
  }
}

TEST(TileBudget, ExpensiveTilesComeFirst) {
  std::vector<double> costs(60, 1.0);
  costs[7] = 40;
  costs[41] = 9;
  costs[50] = 0;
  const TileBudget budget(
      10, [] { return 0.0; }, costs, 0.1, 1);
  EXPECT_EQ(budget.tile_at(0), 7u);
  EXPECT_EQ(budget.tile_at(1), 41u);
  EXPECT_EQ(budget.tile_at(59), 50u);
}

// A tile in progress counts by the time since it began. If half of it were assumed to be done, the
// last correction would be wrong by half of the largest tile.
TEST(TileBudget, ATileThatHasJustBegunIsNotDone) {
  double now = 0;
  std::vector<double> costs(18, 1.0);
  costs[16] = 4;
  costs[17] = 2;
  TileBudget budget(
      10, [&] { return now; }, costs, 0.01, 1);
  for (size_t tile = 0; tile < 16; ++tile) {
    now += 0.01 * budget.begin(tile);
    budget.end(tile);
  }
  const double count = budget.begin(16);
  EXPECT_NEAR(budget.begin(17), count, 0.25 * count);
}

TEST(TileCost, OnePauseDoesNotDecide) {
  std::vector<TileCost> costs(9);
  for (size_t i = 0; i < costs.size(); ++i) {
    const double pace = i < 3 ? 1e-6 : 1.5e-6;
    for (int pass = 0; pass < 3; ++pass) costs[i].add(100, 100 * pace);
  }
  costs[0].add(100, 1);  // a pause
  TileCost slow;         // a tile of which all measurements had pauses
  for (int pass = 0; pass < 3; ++pass) slow.add(100, 1);
  costs.push_back(slow);
  const std::vector<double> seconds = tile_seconds(costs);
  EXPECT_NEAR(seconds[0], 1e-4, 1e-9);
  EXPECT_NEAR(seconds[8], 1.5e-4, 1e-9);
  EXPECT_NEAR(seconds[9], 3e-4, 1e-9);
  EXPECT_TRUE(tile_seconds({}).empty());
  EXPECT_EQ(tile_pauses({}), 1);
  EXPECT_EQ(tile_pauses(std::span(costs).first(1)), 4);
  EXPECT_NEAR(tile_pauses(std::span(costs).subspan(1, 8)), 1, 1e-9);
}

TEST(TileBudget, ResumedTilesLeaveTheTimeToTheOthers) {
  double now = 0;
  TileBudget budget(
      10, [&] { return now; }, std::vector<double>(10, 1.0), 0.1, 1);
  for (size_t tile = 0; tile < 5; ++tile) budget.skip(tile);
  EXPECT_EQ(budget.begin(5), 20u);
}

// Both streams of an estimator need samples from the start.
TEST(TimeBudget, AdaptiveFramesBeginWithAPilot) {
  for (const auto& [estimator, pilot] :
       {std::pair{"nested", 8u}, std::pair{"two-stream", 16u}, std::pair{"kajiya", 16u}}) {
    FrameSettings settings;
    settings.driver = "adaptive";
    settings.time_budget_s = 1;
    settings.estimator = estimator;
    EXPECT_EQ(RenderPlan(settings).samples_per_pixel, pilot) << estimator;
    settings.denoise = true;
    EXPECT_EQ(RenderPlan(settings).samples_per_pixel, 16u) << estimator;
  }
}

}  // namespace
}  // namespace emberline
