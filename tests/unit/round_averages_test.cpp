// What a mean over rounds is and how sure it is, on made-up samples.
#include "renderer/drivers/adaptive/round_averages.h"

#include <gtest/gtest.h>

#include "renderer/core/moments.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using namespace test;

// One pixel, whose rounds have these counts and weights.
struct Round {
  int count;
  double weight;
};

RoundAverages average(std::span<const Round> rounds, uint64_t seed, FilmTile* film) {
  RoundAverages averages;
  TestRandom random(seed, 1);
  film->reset({0, 0, 1, 1});
  for (const Round& round : rounds) {
    for (int k = 0; k < round.count; ++k) {
      const auto value = float(random.next_double());
      film->add(0, 0, 0, 1.0f,
                {.radiance = Rgb(value), .alpha = 1.0f, .first_hit = {}, .rays = {}});
    }
    averages.add_round(*film, round.weight);
  }
  return averages;
}

TEST(RoundAverages, AsSureAsAllSamplesIfTheyCameAsTheWeightsAre) {
  FilmTile film{AovSet()};
  EXPECT_DOUBLE_EQ(
      average(std::vector<Round>{{8, 1}, {8, 1}, {16, 2}}, 1, &film).effective_samples(0), 32);
  // 4^2 / (1 / 8 + 1 / 8 + 4 / 64)
  EXPECT_DOUBLE_EQ(
      average(std::vector<Round>{{8, 1}, {8, 1}, {64, 2}}, 1, &film).effective_samples(0), 51.2);
}

// 20000 averages of uniform numbers, whose variance is 1 / 12: known to 1 %.
TEST(RoundAverages, TheirVarianceIsThatOfASampleOverTheirWorth) {
  const std::vector<Round> rounds = {{8, 1}, {24, 1}, {2, 2}};
  FilmTile film{AovSet()};
  Moments means;
  double effective = 0;
  for (uint64_t seed = 0; seed < 20000; ++seed) {
    const RoundAverages averages = average(rounds, seed, &film);
    float rgba[4];
    averages.resolve(0, rgba);
    means.add(double(rgba[1]));
    effective = averages.effective_samples(0);
  }
  EXPECT_NEAR(means.variance() * effective * 12, 1.0, 0.04);
}

}  // namespace
}  // namespace emberline
