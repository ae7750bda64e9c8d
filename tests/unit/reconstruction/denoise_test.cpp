#include "renderer/reconstruction/denoise.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <thread>

#include "renderer/core/display_error.h"
#include "unit/synthetic_halves.h"

namespace emberline::test {
namespace {

constexpr int kWidth = 96, kHeight = 72;

float checker(int x, int y) { return ((x / 6 + y / 6) & 1) != 0 ? 0.8f : 0.2f; }
float disc(int x, int y) { return (x - 40) * (x - 40) + (y - 36) * (y - 36) < 500 ? 0.7f : 0.1f; }

// A picture with an edge that no feature has, and with edges that the albedo explains.
SyntheticHalves some_picture(float samples = 8.0f, uint32_t seed = 1) {
  SyntheticHalves halves(kWidth, kHeight, samples, seed);
  halves.set_colour([](int x, int y) { return disc(x, y) * checker(x, y) + 0.1f; },
                    [](int x, int) { return x < 30 ? 0.1f : 0.4f; });
  halves.set_albedo(checker, constant(0.02f));
  halves.add_feature([](int x, int y) { return 0.01f * float(x + y); }, constant(0.0f));
  return halves;
}

// The regression is linear in the colours. With equal weights its error would be that of a mean
// over windows of 81 pixels, and noisy weights add to it.
TEST(Denoise, ConstantLinearAndQuadraticPicturesComeBack) {
  const SyntheticHalves::Function truths[] = {
      constant(0.5f), [](int x, int y) { return 0.2f + 0.005f * float(x) + 0.002f * float(y); },
      [](int x, int) { return 0.2f + 0.0001f * float(x * x); }};
  const double least_gain[] = {25.0, 15.0, 15.0};
  for (size_t i = 0; i < 3; ++i) {
    SyntheticHalves halves(kWidth, kHeight, 8.0f);
    halves.set_colour(truths[i], constant(0.3f));
    EXPECT_GT(halves.gain(), least_gain[i]) << i;
  }
}

TEST(Denoise, AFeatureThatExplainsThePictureGivesItBack) {
  const auto texture = [](int x, int y) { return float((x * 7919 + y * 104729) % 97) / 97.0f; };
  SyntheticHalves halves(kWidth, kHeight, 8.0f);
  halves.set_colour([&](int x, int y) { return 0.4f + 0.2f * texture(x, y); }, constant(0.3f));
  EXPECT_LT(halves.gain(), 5.0);
  halves.add_feature(texture, constant(0.0f));
  EXPECT_GT(halves.gain(), 25.0);
}

TEST(Denoise, NoiseOfFeaturesDoesNotLeak) {
  SyntheticHalves halves(kWidth, kHeight, 8.0f);
  halves.set_colour(constant(0.5f), constant(0.3f));
  const double without = halves.gain();
  for (int k = 0; k < 4; ++k) halves.add_feature(constant(1.0f), constant(0.5f));
  EXPECT_GT(halves.gain(), 0.5 * without);
}

TEST(Denoise, KeepsANoiselessPicture) {
  SyntheticHalves halves(kWidth, kHeight, 4.0f);
  halves.set_colour(checker, constant(0.0f));
  const DenoisedPicture out = denoise(halves.input());
  EXPECT_EQ(out.colour[0], halves.raw());
  EXPECT_EQ(out.unchanged_pixels, size_t(kWidth * kHeight));
  EXPECT_EQ(out.squared_error_after, 0.0);
}

TEST(Denoise, NeverMuchWorseThanRaw) {
  for (const float samples : {1.0f, 4.0f, 16.0f, 64.0f, 256.0f, 4096.0f}) {
    EXPECT_GT(some_picture(samples).gain(), 0.98) << samples;
    SyntheticHalves textured(kWidth, kHeight, samples);  // unknown to all features
    textured.set_colour([](int x, int y) { return float((x * 7919 + y * 104729) % 97) / 97.0f; },
                        constant(0.4f));
    EXPECT_GT(textured.gain(), 0.98) << samples;
  }
}

TEST(Denoise, EstimatesTheErrorThatIsLeft) {
  for (const float samples : {8.0f, 32.0f, 128.0f, 512.0f}) {
    const SyntheticHalves halves = some_picture(samples);
    const DenoisedPicture out = denoise(halves.input());
    double before = 0.0, after = 0.0;
    const std::vector<float> raw = halves.raw();
    for (size_t i = 0; i < raw.size(); ++i) {
      const auto squared = [&](float value) {
        const double d = double(display_value(value)) - double(display_value(halves.truth()[i]));
        return d * d;
      };
      before += squared(raw[i]);
      after += squared(out.colour[0][i]);
    }
    EXPECT_NEAR(std::sqrt(out.squared_error_before / before), 1.0, 0.2) << samples;
    EXPECT_GT(std::sqrt(out.squared_error_after / after), 0.7) << samples;
    EXPECT_LT(std::sqrt(out.squared_error_after / after), 1.4) << samples;
    double sum = 0.0;
    for (const float error : out.error) sum += double(error) * double(error);
    EXPECT_NEAR(sum, out.squared_error_after, 1e-4 * sum);
  }
}

void expect_sum_of_three(const DenoisedPicture& out) {
  ASSERT_EQ(out.parts.size(), 3u);
  for (size_t c = 0; c < 3; ++c) {
    for (size_t i = 0; i < out.colour[c].size(); ++i) {
      const float sum = out.parts[0][c][i] + out.parts[1][c][i] + out.parts[2][c][i];
      ASSERT_NEAR(sum, out.colour[c][i], 2e-5f);
    }
  }
}

TEST(Denoise, PartsStillAddUp) {
  SyntheticHalves halves = some_picture();
  for (const float share : {0.25f, 0.6f, 0.15f}) halves.add_part(share);
  expect_sum_of_three(denoise(halves.input()));
  halves.blur_with_neighbours();
  const DenoisedPicture out = denoise(halves.input());
  expect_sum_of_three(out);
  // Each part keeps its share of every pixel, although neighbours share their samples.
  for (size_t i = 0; i < out.error.size(); ++i) {
    ASSERT_NEAR(out.parts[1][1][i], 0.6f * out.colour[1][i], 1e-4f);
  }
}

TEST(Denoise, DarkPartsStayDark) {
  SyntheticHalves halves = some_picture();
  halves.add_part(1.0f);
  halves.add_part(0.0f);
  halves.blur_with_neighbours();
  const DenoisedPicture out = denoise(halves.input());
  EXPECT_EQ(out.parts[1][0], std::vector<float>(out.error.size(), 0.0f));
}

void expect_equal_rows(const DenoisedPicture& whole, const DenoisedPicture& rows, int begin) {
  const size_t first = size_t(begin) * size_t(kWidth);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_TRUE(std::equal(rows.colour[c].begin(), rows.colour[c].end(),
                           whole.colour[c].begin() + std::ptrdiff_t(first)));
    for (size_t p = 0; p < whole.parts.size(); ++p) {
      EXPECT_TRUE(std::equal(rows.parts[p][c].begin(), rows.parts[p][c].end(),
                             whole.parts[p][c].begin() + std::ptrdiff_t(first)));
    }
  }
  EXPECT_EQ(rows.parts.size(), whole.parts.size());
  EXPECT_TRUE(std::equal(rows.error.begin(), rows.error.end(),
                         whole.error.begin() + std::ptrdiff_t(first)));
}

void expect_same_bits(const SyntheticHalves& halves) {
  const DenoiseInput input = halves.input();
  DenoisedPicture one, two;
  tbb::task_arena(1).execute([&] { one = denoise(input); });
  tbb::task_arena(2).execute([&] { two = denoise(input); });
  expect_equal_rows(one, two, 0);
  EXPECT_EQ(one.squared_error_after, two.squared_error_after);
  size_t unchanged_pixels = 0;
  for (const auto& [begin, end] : {std::pair(0, 5), std::pair(5, 41), std::pair(41, kHeight)}) {
    const DenoisedPicture band = denoise(input, begin, end);
    expect_equal_rows(one, band, begin);
    unchanged_pixels += band.unchanged_pixels;
  }
  EXPECT_EQ(unchanged_pixels, one.unchanged_pixels);
  EXPECT_TRUE(denoise(input, 7, 7).colour[0].empty());
}

TEST(Denoise, SameBitsForAnyThreadsAndBands) {
  SyntheticHalves halves = some_picture();
  halves.add_part(0.5f);
  expect_same_bits(halves);
  SyntheticHalves sharing = some_picture();
  sharing.blur_with_neighbours();
  expect_same_bits(sharing);
}

// The input is a band of rows, as a reader of a streamed file has it.
TEST(Denoise, ABandNeedsNoMoreThanTheMargin) {
  SyntheticHalves halves = some_picture();
  halves.blur_with_neighbours();
  const DenoiseInput input = halves.input();
  const DenoisedPicture whole = denoise(input);
  const int begin = 50, end = 54, first = begin - kDenoiseMargin;
  DenoiseInput rows = input;
  rows.height = kHeight - first;
  rows.y0 = first;
  const auto cut = [&](HalfPlanes& planes) {
    const size_t skipped = size_t(first * kWidth);
    planes = {planes.a.subspan(skipped), planes.b.subspan(skipped)};
  };
  cut(rows.samples);
  for (HalfPlanes& planes : rows.colour) cut(planes);
  for (HalfPlanes& planes : rows.albedo) cut(planes);
  for (HalfPlanes& planes : rows.features) cut(planes);
  for (HalfPlanes& planes : rows.shared) cut(planes);
  const DenoisedPicture band = denoise(rows, begin - first, end - first);
  EXPECT_TRUE(std::equal(band.colour[1].begin(), band.colour[1].end(),
                         whole.colour[1].begin() + std::ptrdiff_t(begin * kWidth)));
}

// If DenoiseInput::shared is given, the result is the same as if that picture were the colour
// input.
TEST(Denoise, SamplesAreShared) {
  SyntheticHalves halves = some_picture();
  const DenoisedPicture unshared = denoise(halves.input());
  halves.blur_with_neighbours();
  SyntheticHalves mean = halves;
  for (size_t s = 0; s < 2; ++s) mean.colour(s) = halves.shared(s);
  mean.clear_shared();
  const DenoisedPicture shared = denoise(halves.input()), expected = denoise(mean.input());
  for (size_t i = 0; i < shared.error.size(); ++i) {
    ASSERT_NEAR(shared.colour[0][i], expected.colour[0][i], 1e-4f) << i;
  }
  // Compares the squared error before and after filtering.
  EXPECT_NEAR(shared.squared_error_before / unshared.squared_error_before, 1.0, 0.1);
  EXPECT_NEAR(shared.squared_error_after / expected.squared_error_after, 1.0, 1e-3);
  halves.add_part(0.5f);
  EXPECT_EQ(denoise(halves.input()).colour, shared.colour);
}

TEST(Denoise, NoNumberOutOfNonNumbers) {
  SyntheticHalves halves = some_picture();
  halves.blur_with_neighbours();
  halves.shared(0)[510] = std::numeric_limits<float>::quiet_NaN();
  halves.shared(1)[2510] = -std::numeric_limits<float>::infinity();
  halves.shared(1)[2520] = 3e38f;
  halves.add_feature(checker, constant(0.0f));
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  halves.colour(0)[500] = kNan;
  halves.colour(1)[900] = kInfinity;
  halves.colour(1)[1900] = 3e38f;
  halves.feature(0)[700] = -kInfinity;
  halves.feature(1)[702] = 1e30f;
  halves.counts()[333] = kNan;
  const DenoisedPicture out = denoise(halves.input());
  for (size_t i = 0; i < out.error.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(out.colour[c][i])) << i;
    ASSERT_TRUE(out.error[i] >= 0.0f && out.error[i] <= 0.5f) << i;
  }
}

// A factor of exposure or light only scales the picture. The error is finite and at most what a
// display shows, and it falls with the brightness of a dark picture.
TEST(Denoise, AFramesScaleMakesNoNumberANonNumber) {
  const SyntheticHalves plain = some_picture();
  const DenoisedPicture reference = denoise(plain.input());
  for (int exponent = -20; exponent <= 20; ++exponent) {
    SCOPED_TRACE(exponent);
    const float scale = std::ldexp(1.0f, exponent);
    SyntheticHalves halves = some_picture();
    for (size_t s = 0; s < 2; ++s) {
      for (float& value : halves.colour(s)) value *= scale;
    }
    const DenoisedPicture out = denoise(halves.input());
    double square = 0.0, of_reference = 0.0;
    for (size_t i = 0; i < out.error.size(); ++i) {
      ASSERT_TRUE(out.error[i] >= 0.0f && out.error[i] <= 0.5f) << i << ' ' << out.error[i];
      // The error is nowhere larger than the noise times the display's steepest slope.
      ASSERT_LT(out.error[i], 12.92f * 0.5f * scale) << i;
      const double value = double(out.colour[0][i]) / double(scale);
      square += (value - double(plain.truth()[i])) * (value - double(plain.truth()[i]));
      of_reference += std::pow(double(reference.colour[0][i]) - double(plain.truth()[i]), 2);
    }
    EXPECT_TRUE(std::isfinite(out.squared_error_after) && std::isfinite(out.squared_error_before));
    EXPECT_LT(square, 2.0 * of_reference);
    if (exponent >= 0) {
      EXPECT_NEAR(square / of_reference, 1.0, 0.05);
    }
  }
}

// Pixels without noise have zero error at any brightness, even a negative one.
TEST(Denoise, BrightLightWithoutNoiseHasNoError) {
  for (const float light : {1.0f, 8192.0f, 16385.0f, 32768.0f, 1e6f, 1e10f, 1e15f}) {
    for (const float sign : {1.0f, -1.0f}) {
      SCOPED_TRACE(sign * light);
      SyntheticHalves halves(kWidth, kHeight, 8.0f);
      halves.set_colour(constant(sign * light), constant(0.0f));
      for (const float error : denoise(halves.input()).error) ASSERT_EQ(error, 0.0f);
    }
  }
}

// Light is not negative, so a negative value stays in its pixel and does not affect its neighbours.
TEST(Denoise, OneNegativeValueSpoilsOnePixel) {
  for (const float bad : {-1e3f, -1e4f, -1e10f, -1e15f, -3e38f}) {
    SCOPED_TRACE(bad);
    SyntheticHalves halves = some_picture();
    const DenoisedPicture good = denoise(halves.input());
    halves.colour(0)[36 * kWidth + 48] = bad;
    const DenoisedPicture out = denoise(halves.input());
    int spoilt = 0, unsure = 0;
    for (size_t i = 0; i < out.error.size(); ++i) {
      ASSERT_TRUE(out.error[i] >= 0.0f && out.error[i] <= 0.5f) << i;
      spoilt += std::abs(out.colour[0][i] - good.colour[0][i]) > 0.1f;
      unsure += out.error[i] > good.error[i] + 0.1f;
    }
    EXPECT_EQ(spoilt, 1);
    EXPECT_LE(unsure, 1);
  }
}

TEST(Denoise, FillsPixelsWithoutSamplesFromTheirNeighbours) {
  SyntheticHalves halves(kWidth, kHeight, 8.0f);
  halves.set_colour(constant(0.5f), constant(0.1f));
  for (size_t i = 2000; i < 2004; ++i) {
    halves.counts()[i] = 0.0f;
    halves.colour(0)[i] = halves.colour(1)[i] = 0.0f;
  }
  const DenoisedPicture out = denoise(halves.input());
  for (size_t i = 2000; i < 2004; ++i) EXPECT_NEAR(out.colour[0][i], 0.5f, 0.05f);
}

TEST(Denoise, WithoutASecondHalfNothingIsKnown) {
  SyntheticHalves halves = some_picture();
  DenoiseInput input = halves.input();
  const std::vector<float> none(size_t(kWidth * kHeight), 0.0f);
  input.samples.b = none;
  const DenoisedPicture out = denoise(input);
  EXPECT_EQ(out.colour[0], halves.colour(0));
  EXPECT_EQ(out.unchanged_pixels, none.size());
  EXPECT_EQ(out.error[77], 0.5f);  // the maximum that a display can show
}

TEST(Denoise, SmallestPictures) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(3, 1), std::pair(1, 5)}) {
    SyntheticHalves halves(width, height, 1.0f);
    halves.set_colour(constant(0.5f), constant(0.1f));
    halves.set_albedo(constant(0.5f), constant(0.0f));
    const DenoisedPicture out = denoise(halves.input());
    ASSERT_EQ(out.error.size(), size_t(width * height));
    for (const float value : out.colour[2]) EXPECT_NEAR(value, 0.5f, 0.5f);
  }
}

TEST(Denoise, StopsWhenAsked) {
  std::jthread stopped([](const std::stop_token& stop) {
    while (!stop.stop_requested()) std::this_thread::yield();
    EXPECT_TRUE(denoise(some_picture().input(), stop).colour[0].empty());
  });
}

// A sample a thousand times as bright as the picture keeps its energy and does not smear.
TEST(Denoise, AnOutlierNeitherSmearsNorVanishes) {
  SyntheticHalves halves(kWidth, kHeight, 16.0f);
  halves.set_colour(constant(0.2f), constant(0.1f));
  const std::vector<float> plain = denoise(halves.input()).colour[0];
  const size_t at = 36 * kWidth + 48;
  halves.colour(0)[at] += 200.0f;
  const std::vector<float> out = denoise(halves.input()).colour[0];
  double light = 0.0;
  float most = 0.0f;
  for (size_t i = 0; i < out.size(); ++i) {
    light += double(out[i]) - double(plain[i]);
    if (i != at) most = std::max(most, std::abs(out[i] - plain[i]));
  }
  EXPECT_NEAR(light, 100.0, 5.0);
  EXPECT_LT(most, 0.05f);
}

// The filter spreads rare light, as from lamps that are reflected in water, over its neighbourhood.
// This must not brighten the dark pixels next to it.
TEST(Denoise, DarkPixelsNextToRareLightStayDark) {
  SyntheticHalves halves(kWidth, kHeight, 16.0f);
  halves.set_colour(constant(0.0005f), constant(0.0002f));
  const auto lit = [](size_t i) { return i % kWidth % 16 < 3; };
  std::mt19937 random(7);
  for (size_t i = 0; i < size_t(kWidth * kHeight); ++i) {
    for (size_t s = 0; s < 2; ++s) {
      if (lit(i) && random() % 8 == 0) halves.colour(s)[i] += 0.4f;
    }
  }
  const std::vector<float> out = denoise(halves.input()).colour[0];
  double squares = 0.0, dark = 0.0;
  for (size_t i = 0; i < out.size(); ++i) {
    if (lit(i)) continue;
    squares += std::pow(double(out[i] - halves.truth()[i]), 2);
    ++dark;
  }
  EXPECT_LT(std::sqrt(squares / dark), 0.2 * 0.0005);
}

// A random quarter of the pixels is lit, by so few samples that their noise does not separate these
// pixels from their dark neighbours. The halves do, because dark pixels are dark in both.
TEST(Denoise, DarkPixelsAmongRareLightStayDark) {
  SyntheticHalves halves(kWidth, kHeight, 16.0f);
  halves.set_colour(constant(0.002f), constant(0.001f));
  std::mt19937 random(11);
  std::vector<bool> lit;
  for (size_t i = 0; i < size_t(kWidth * kHeight); ++i) {
    lit.push_back(random() % 4 == 0);
    for (size_t s = 0; s < 2; ++s) {
      if (lit[i] && random() % 2 == 0) halves.colour(s)[i] += 0.3f;
    }
  }
  const std::vector<float> out = denoise(halves.input()).colour[0];
  double squares = 0.0, dark = 0.0;
  for (size_t i = 0; i < out.size(); ++i) {
    if (lit[i]) continue;
    squares += std::pow(double(out[i] - halves.truth()[i]), 2);
    ++dark;
  }
  EXPECT_LT(std::sqrt(squares / dark), 0.006);
}

// Few samples hit the specks. The estimate of the error includes light that neither half has seen.
TEST(Denoise, TheErrorOfLightThatNeitherHalfSawIsExpected) {
  const auto speck = [](int x, int y) { return (x * 7919 + y * 104729) % 97 < 12; };
  double truth = 0.0, estimate = 0.0, raw = 0.0, before = 0.0;
  int blocks = 0, covered = 0;
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    SyntheticHalves halves(kWidth, kHeight, 4.0f, seed);
    halves.set_colour([&](int x, int y) { return speck(x, y) ? 0.02f : 0.002f; },
                      constant(0.0005f));
    std::mt19937 random(seed);
    for (size_t s = 0; s < 2; ++s) {
      for (size_t i = 0; i < size_t(kWidth * kHeight); ++i) {
        if (halves.truth()[i] < 0.01f) continue;
        halves.colour(s)[i] += random() % 32 == 0 ? 0.018f * 31 : -0.018f;
      }
    }
    const DenoisedPicture out = denoise(halves.input());
    const std::vector<float> came = halves.raw();
    const auto squared = [&](float value, size_t i) {
      return std::pow(double(display_value(value)) - double(display_value(halves.truth()[i])), 2);
    };
    estimate += out.squared_error_after;
    before += out.squared_error_before;
    for (size_t i = 0; i < came.size(); ++i) {
      truth += squared(out.colour[0][i], i);
      raw += squared(came[i], i);
    }
    for (int y = 0; y + 16 <= kHeight; y += 16) {
      for (int x = 0; x + 16 <= kWidth; x += 16) {
        double true_error = 0.0, told = 0.0;
        for (int k = 0; k < 256; ++k) {
          const size_t i = size_t((y + k / 16) * kWidth + x + k % 16);
          true_error += squared(out.colour[0][i], i);
          told += double(out.error[i]) * double(out.error[i]);
        }
        ++blocks;
        covered += true_error <= 4 * told;
      }
    }
  }
  EXPECT_NEAR(std::sqrt(estimate / truth), 1.0, 0.3);
  EXPECT_NEAR(std::sqrt(before / raw), 1.0, 0.3);
  EXPECT_GE(covered, 0.95 * blocks);
}

// The wires are thinner than a pixel, so their light is in few samples of few pixels.
TEST(Denoise, ThinWiresKeepTheirLight) {
  SyntheticHalves halves(kWidth, kHeight, 16.0f);
  const auto wire = [](int x, int y) { return (x + 2 * y) % 23 == 0 ? 0.4f : 0.0f; };
  halves.set_colour([&](int x, int y) { return 0.01f + wire(x, y); },
                    [&](int x, int y) { return 0.003f + wire(x, y); });
  const auto sum = [](const std::vector<float>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0);
  };
  const std::vector<float> out = denoise(halves.input()).colour[0];
  EXPECT_NEAR(sum(out), sum(halves.truth()), 0.01 * sum(halves.truth()));
  EXPECT_LT(halves.squared_error(out), 1.02 * halves.squared_error(halves.raw()));
}

}  // namespace
}  // namespace emberline::test
