// Tests averages over rounds and their variance, on synthetic samples.
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include "renderer/core/moments.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

using namespace test;

// A round of a single pixel, with its number of samples and its weight.
struct Round {
  int count;
  double weight;
};

// Averages numbers in [0, 1) that are independent, or stratified with one number in each of `count`
// strata. The mean of a round has the variance 1 / (12 count) or 1 / (12 count^3).
RoundAverages average(std::span<const Round> rounds, bool stratified, int streams, uint64_t seed) {
  RoundAverages averages;
  TestRandom random(seed, 1);
  FilmTile film(AovSet(), {.squares = true});
  film.reset({0, 0, 1, 1});
  for (const Round& round : rounds) {
    for (int k = 0; k < round.count; ++k) {
      const double u = random.next_double(), value = stratified ? (k + u) / double(round.count) : u;
      film.add(0, 0,
               {{.radiance = Rgb(float(value)), .alpha = 1.0f, .first_hit = {}, .rays = {}},
                1.0f,
                k % streams});
    }
    averages.add_round(film, round.weight);
  }
  return averages;
}

struct Variances {
  double truth, estimate;
};

Variances variances(std::span<const Round> rounds, bool stratified, int streams = 1) {
  Moments means, estimates;
  for (uint64_t seed = 0; seed < 20000; ++seed) {
    const RoundAverages averages = average(rounds, stratified, streams, seed);
    means.add(averages.mean(0, 1));
    estimates.add(averages.variance(0, 1));
  }
  return {means.variance(), estimates.mean()};
}

// 20000 averages determine both variances to 1 %.
void expect_right(std::span<const Round> rounds, bool stratified) {
  const Variances v = variances(rounds, stratified);
  double weights = 0, expected = 0;
  for (const Round& r : rounds) {
    weights += r.weight;
    expected += r.weight * r.weight / (12 * std::pow(r.count, stratified ? 3 : 1));
  }
  expected /= weights * weights;
  EXPECT_NEAR(v.truth / expected, 1.0, 0.04);
  EXPECT_NEAR(v.estimate / expected, 1.0, 0.04);
}

TEST(RoundAverages, KnowTheirVarianceWhereTheLastRoundEndsEarly) {
  expect_right(std::vector<Round>{{8, 1}, {24, 1}, {2, 2}, {5, 1}}, false);
}

// A round of two samples is far less stratified than a round of 24, but has a larger weight.
TEST(RoundAverages, VarianceIsRightForStratifiedRounds) {
  expect_right(std::vector<Round>{{8, 1}, {24, 1}, {2, 2}, {40, 4}}, true);
  expect_right(std::vector<Round>{{8, 1}, {24, 1}, {40, 2}, {2, 4}}, true);
}

TEST(RoundAverages, OneRoundUsesItsSpreadOrItsTwoStreams) {
  const std::vector<Round> one = {{16, 1}};
  for (const int streams : {1, 2}) {
    const Variances v = variances(one, false, streams);
    EXPECT_NEAR(v.estimate / v.truth, 1.0, 0.06) << streams;
  }
}

}  // namespace
}  // namespace emberline
