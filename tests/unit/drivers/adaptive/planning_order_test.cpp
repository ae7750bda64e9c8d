// Tests the order of the planner's sums, and which pixels come first among equal ones.
#include <gtest/gtest.h>

#include <vector>

#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/ordered_sum.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

struct Indices {
  std::vector<size_t> all;
  Indices& operator+=(const Indices& other) {
    all.insert(all.end(), other.all.begin(), other.all.end());
    return *this;
  }
};

TEST(OrderedSum, EveryIndexOnceAndInOrder) {
  for (const size_t count : {0, 1, 15, 16, 17, 8191, 8192, 8193, 50'000}) {
    const Indices sum = ordered_sum(count, [](size_t begin, size_t end) {
      Indices part;
      for_lanes(begin, end, [&](size_t i, size_t lane) {
        EXPECT_EQ(lane, (i - begin) % kSumLanes);
        part.all.push_back(i);
      });
      return part;
    });
    ASSERT_EQ(sum.all.size(), count);
    for (size_t i = 0; i < count; ++i) ASSERT_EQ(sum.all[i], i);
  }
}

TEST(OrderedSum, LanesAddUp) {
  float lanes[kSumLanes];
  for (size_t i = 0; i < kSumLanes; ++i) lanes[i] = float(i + 1);
  EXPECT_EQ(sum_of_lanes(lanes), 136.0);
}

constexpr int kSize = 32;

// The pixels that a historical estimator chooses in a constant picture, where all errors are equal.
// `upper` counts those in the upper half.
struct Chosen {
  std::vector<bool> pixels;
  int upper = 0, all = 0;
};
Chosen choose_for_constant(uint32_t seed) {
  FilmTile film(AovSet{}, {.squares = true, .rays = true});
  film.reset({0, 0, kSize, kSize});
  RoundPlanner planner({.estimator = "painter-sloan", .budget = 64}, kSize, kSize, seed);
  const uint32_t pilot = planner.targets()[0];
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      for (uint32_t k = 0; k < pilot; ++k) {
        film.add(x, y,
                 {{.radiance = Rgb(0.5f), .alpha = 1.0f, .first_hit = {}, .rays = {}}, 1.0f, 0});
      }
    }
  }
  EXPECT_TRUE(planner.plan(film));
  Chosen chosen;
  for (size_t i = 0; i < planner.targets().size(); ++i) {
    const bool more = planner.targets()[i] > pilot;
    chosen.pixels.push_back(more);
    chosen.all += more;
    chosen.upper += more && i < planner.targets().size() / 2;
  }
  return chosen;
}

TEST(RoundPlanner, EqualErrorsAreServedAllOverTheWindow) {
  const Chosen one = choose_for_constant(1), other = choose_for_constant(2);
  constexpr int kWindowPixels = kSize * kSize;
  EXPECT_EQ(one.all, kWindowPixels / 2);
  // Half of the chosen pixels should be in each half. The standard deviation is 8, and the
  // tolerance is 5 deviations, a false alarm for 6e-7 of all seeds.
  EXPECT_NEAR(one.upper, kWindowPixels / 4, 40);
  EXPECT_NEAR(other.upper, kWindowPixels / 4, 40);
  int both = 0;
  for (size_t i = 0; i < size_t(kWindowPixels); ++i) both += one.pixels[i] && other.pixels[i];
  EXPECT_NEAR(both, kWindowPixels / 4, 40);
  EXPECT_EQ(one.pixels, choose_for_constant(1).pixels);
}

}  // namespace
}  // namespace emberline
