// Compares the film's statistics for the estimators with sums done by hand.
#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <vector>

namespace emberline {
namespace {

FilmTile film_of(const Rect& crop) {
  FilmTile film(AovSet{}, {.squares = true, .rays = true});
  film.reset(crop);
  return film;
}

void add(FilmTile* film, int x, int y, int stream, const Rgb& radiance, uint32_t rays = 1) {
  const SampleRays traced{.scatter = rays - 1};
  film->add(x, y, {{.radiance = radiance, .alpha = 1.0f, .rays = traced}, 1.0f, stream});
}

PixelStatistics gather(const FilmTile& film) {
  PixelStatistics pixels;
  gather_statistics(film, &pixels);
  return pixels;
}

TEST(PixelStatistics, TwoStreams) {
  FilmTile film = film_of({10, 20, 13, 22});
  // Stream A holds 1, 3 and 5, and stream B holds 2 and 6. The mean is 17/5, A - B is 3 - 4, the
  // sum of squares is 75, and the variance is (75 - 17^2 / 5) / 4.
  for (const float x : {1.0f, 3.0f, 5.0f}) add(&film, 11, 21, 0, {x, 10 * x, 0}, 6);
  for (const float x : {2.0f, 6.0f}) add(&film, 11, 21, 1, {x, 10 * x, 0}, 6);
  const PixelStatistics pixels = gather(film);
  ASSERT_EQ(pixels.width, 3);
  ASSERT_EQ(pixels.height, 2);
  constexpr size_t i = 4;  // column 1 of row 1
  EXPECT_EQ(pixels.count[i], 5.0f);
  EXPECT_EQ(pixels.second_count[i], 2.0f);
  EXPECT_FLOAT_EQ(pixels.mean[0][i], 3.4f);
  EXPECT_FLOAT_EQ(pixels.mean[1][i], 34.0f);
  EXPECT_EQ(pixels.mean[2][i], 0.0f);
  EXPECT_FLOAT_EQ(pixels.stream_difference[0][i], -1.0f);
  EXPECT_FLOAT_EQ(pixels.stream_difference[1][i], -10.0f);
  EXPECT_FLOAT_EQ(pixels.variance[0][i], 4.3f);
  EXPECT_FLOAT_EQ(pixels.variance[1][i], 430.0f);
  EXPECT_EQ(pixels.variance[2][i], 0.0f);
  EXPECT_FLOAT_EQ(pixels.cost[i], 5.17f);  // 6 rays, of which the camera ray costs .17
}

TEST(PixelStatistics, FewSamplesAreNotDividedByZero) {
  FilmTile film = film_of({0, 0, 3, 1});
  add(&film, 1, 0, 0, Rgb(4.0f));
  add(&film, 2, 0, 0, Rgb(4.0f));
  add(&film, 2, 0, 0, Rgb(8.0f));
  const PixelStatistics pixels = gather(film);
  EXPECT_EQ(pixels.count, (std::vector<float>{0, 1, 2}));
  EXPECT_EQ(pixels.second_count, (std::vector<float>{0, 0, 0}));
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(pixels.mean[c], (std::vector<float>{0, 4, 6}));
    EXPECT_EQ(pixels.variance[c], (std::vector<float>{0, 0, 8}));
    EXPECT_EQ(pixels.stream_difference[c], (std::vector<float>{0, 0, 0}));  // one stream only
  }
  EXPECT_EQ(pixels.cost, (std::vector<float>{1, 0.17f, 0.17f}));  // above 0 even without a ray
}

TEST(PixelStatistics, TheSecondStreamAloneHasNoDifference) {
  FilmTile film = film_of({0, 0, 1, 1});
  add(&film, 0, 0, 1, Rgb(4.0f));
  const PixelStatistics pixels = gather(film);
  EXPECT_EQ(pixels.second_count[0], 1.0f);
  EXPECT_EQ(pixels.mean[0][0], 4.0f);
  EXPECT_EQ(pixels.stream_difference[0][0], 0.0f);
}

TEST(PixelStatistics, HugeRadianceStaysFinite) {
  FilmTile film = film_of({0, 0, 1, 1});
  add(&film, 0, 0, 0, Rgb(3e38f));
  add(&film, 0, 0, 1, Rgb(-3e38f));
  const PixelStatistics pixels = gather(film);
  EXPECT_EQ(pixels.mean[0][0], 0.0f);
  EXPECT_EQ(pixels.stream_difference[0][0], 1e30f);
  EXPECT_EQ(pixels.variance[0][0], 1e30f);
}

// The samples are equal, and their square is not exact in float. Rounding leaves a negligible
// variance, which is never negative.
TEST(PixelStatistics, EqualSamplesHaveNoVariance) {
  FilmTile film = film_of({0, 0, 64, 1});
  for (int x = 0; x < 64; ++x) {
    for (int k = 0; k < 1000; ++k) add(&film, x, 0, k & 1, Rgb(0.1f + 0.37f * float(x)));
  }
  const PixelStatistics pixels = gather(film);
  for (size_t x = 0; x < 64; ++x) {
    EXPECT_GE(pixels.variance[0][x], 0.0f);
    EXPECT_LT(pixels.variance[0][x], 1e-12f * pixels.mean[0][x] * pixels.mean[0][x]) << x;
    EXPECT_NEAR(pixels.stream_difference[0][x], 0.0f, 1e-6f * pixels.mean[0][x]);
  }
}

// Pixels are read in blocks. Each pixel keeps its own sums, whatever the size of the film.
TEST(PixelStatistics, EveryPixelOfAnySize) {
  for (const int width : {1, 63, 64, 65, 150}) {
    FilmTile film = film_of({5, 7, 5 + width, 10});
    for (int i = 0; i < 3 * width; ++i) {
      const int x = 5 + i % width, y = 7 + i / width;
      // The means of the streams are i + 1 and i + 3, and their counts are 1 and 2.
      add(&film, x, y, 0, Rgb(float(i + 1)), uint32_t(i + 1));
      for (const int value : {i + 2, i + 4})
        add(&film, x, y, 1, Rgb(float(value)), uint32_t(i + 1));
    }
    const PixelStatistics pixels = gather(film);
    for (int i = 0; i < 3 * width; ++i) {
      const auto p = size_t(i);
      ASSERT_EQ(pixels.count[p], 3.0f) << i << " of width " << width;
      ASSERT_EQ(pixels.second_count[p], 2.0f);
      ASSERT_FLOAT_EQ(pixels.cost[p], 0.17f + float(i)) << i << " of width " << width;
      for (size_t c = 0; c < 3; ++c) {
        ASSERT_FLOAT_EQ(pixels.mean[c][p], float(i) + 7.0f / 3) << i << " of width " << width;
        ASSERT_FLOAT_EQ(pixels.stream_difference[c][p], -2.0f);
        ASSERT_NEAR(pixels.variance[c][p], 7.0f / 3, 1e-4);
      }
    }
  }
}

TEST(PixelStatistics, GatheringReplacesOldValues) {
  FilmTile film = film_of({0, 0, 2, 2});
  PixelStatistics pixels;
  pixels.resize(100, 3);
  for (float& n : pixels.count) n = 7.0f;
  gather_statistics(film, &pixels);
  EXPECT_EQ(pixels.size(), 4u);
  EXPECT_EQ(pixels.count, (std::vector<float>{0, 0, 0, 0}));
}

TEST(PixelStatistics, RelMseEpsilon) {
  PixelStatistics pixels;
  EXPECT_FLOAT_EQ(rel_mse_epsilon(pixels), 1e-6f);
  pixels.resize(2, 1);
  EXPECT_FLOAT_EQ(rel_mse_epsilon(pixels), 1e-6f);
  pixels.mean = {{{1, 2}, {3, 4}, {5, 9}}};  // the mean is 4
  EXPECT_FLOAT_EQ(rel_mse_epsilon(pixels), 0.16f);
}

}  // namespace
}  // namespace emberline
