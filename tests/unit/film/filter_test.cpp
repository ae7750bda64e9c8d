// Compares the map of each pixel filter with its profile, whose integral is known in closed form.
// Every row of the table is tested.
#include "renderer/film/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "support/chi_square.h"
#include "unit/sample_statistics.h"
#include "unit/table_names.h"

namespace emberline {
namespace {

class EveryFilter : public testing::TestWithParam<std::string> {
 protected:
  const FilterEntry& entry() const {
    for (const FilterEntry& e : filter_table()) {
      if (e.name == GetParam()) return e;
    }
    throw std::logic_error("not in the table");
  }
  PixelFilter filter() const { return PixelFilter::create(GetParam()); }
};
std::string test_name(const testing::TestParamInfo<std::string>& test) {
  std::string name = test.param;
  std::erase(name, '-');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Table, EveryFilter, testing::ValuesIn(test::names_of(filter_table())),
                         test_name);

Vec2f random_point(uint32_t i) {
  const uint64_t bits = hash64(0xf117e4u + uint64_t(i));
  return {to_unit_float(uint32_t(bits)), to_unit_float(uint32_t(bits >> 32))};
}

// Integrates f over [0, 1] by the midpoint rule on `steps` cells.
double integrate(const std::function<double(double)>& f, int steps = 200000) {
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += f((i + 0.5) / steps);
  return sum / steps;
}

TEST_P(EveryFilter, OffsetsStayInTheSupport) {
  for (const float radius : {1e-3f, 0.5f, entry().default_radius, 7.3f, 32.0f}) {
    const PixelFilter f = PixelFilter::create(GetParam(), radius);
    const float edges[] = {0.0f, 0x1p-24f,        0.25f,           0.5f - 0x1p-24f,
                           0.5f, 0.5f + 0x1p-24f, kOneMinusEpsilon};
    for (const float x : edges) {
      for (const float y : edges) {
        const FilterSample s = f.sample({x, y});
        ASSERT_TRUE(std::abs(s.offset.x) <= radius && std::abs(s.offset.y) <= radius) << s.offset;
        ASSERT_TRUE(std::isfinite(s.weight));
        ASSERT_EQ(s.offset.x >= 0.0f, x >= 0.5f) << "the half of u is the half of the pixel";
      }
    }
    EXPECT_NEAR(f.sample({0.0f, 0.5f}).offset.x, -radius, 1e-6f * radius);
    EXPECT_EQ(f.sample({0.5f, 0.5f}).offset, Vec2f(0.0f));
    EXPECT_GT(f.sample({kOneMinusEpsilon, 0.5f}).offset.x, 0.9f * radius);
  }
}

// The map increases in u, so that stratified numbers give stratified offsets. The integral of |f|
// up to the offset must be u. The test computes the integral by quadrature in double, while the
// table is linear between 253 knots.
TEST_P(EveryFilter, MapInvertsTheProfilesIntegral) {
  const FilterEntry& e = entry();
  const PixelFilter f = filter();
  constexpr int kSteps = 1 << 16;
  std::vector<double> parts = {0.0};  // integrals of |f| over [0, i / kSteps]
  for (int i = 0; i < kSteps; ++i) {
    parts.push_back(parts.back() + std::abs(e.profile((i + 0.5) / kSteps)));
  }
  float previous = -2.0f * e.default_radius;
  for (uint32_t i = 0; i < (1u << 16); ++i) {
    const float u = (float(i) + 0.37f) * 0x1p-16f;
    const float offset = f.sample({u, 0.5f}).offset.x;
    ASSERT_GE(offset, previous) << "u " << u;
    previous = offset;
    const double place = std::abs(double(offset)) / double(e.default_radius) * kSteps;
    const size_t below = std::min(size_t(place), size_t(kSteps - 1));
    const double part =
        (parts[below] + (place - double(below)) * (parts[below + 1] - parts[below])) / parts.back();
    ASSERT_NEAR(part, std::abs(2.0 * double(u) - 1.0), 4e-5) << "u " << u;
  }
}

TEST_P(EveryFilter, SymmetricAboutTheCentre) {
  const PixelFilter f = filter();
  for (uint32_t i = 0; i < 10000; ++i) {
    const Vec2f u = random_point(i);
    if (u.x == 0.0f || u.x == 0.5f) continue;
    const FilterSample a = f.sample(u), b = f.sample({1.0f - u.x, u.y}), c = f.sample({u.y, u.x});
    EXPECT_EQ(a.offset.x, -b.offset.x);
    EXPECT_EQ(a.offset.y, b.offset.y);
    EXPECT_EQ(c.offset, Vec2f(a.offset.y, a.offset.x));
    EXPECT_EQ(a.weight, c.weight);
  }
}

// The offsets follow the profile. The chi-square test on a 20 x 20 grid has a false-alarm rate of
// 1e-6.
TEST_P(EveryFilter, ChiSquare) {
  const FilterEntry& e = entry();
  const PixelFilter f = filter();
  const double total =
      2 * integrate([&](double t) { return std::abs(e.profile(2 * t - 1)); }, 20000);
  EXPECT_TRUE(test::chi_square_test(
      [&](test::TestRandom& random) -> std::optional<test::ChiSquarePoint> {
        const Vec2f offset = f.sample(random.vec2()).offset;
        return test::ChiSquarePoint{double(offset.x / e.default_radius),
                                    double(offset.y / e.default_radius), 1};
      },
      [&](double x, double y) {
        return std::abs(e.profile(x)) * std::abs(e.profile(y)) / square(total);
      },
      {-1, 1, -1, 1}, {.bins_x = 20, .bins_y = 20, .samples = 1'000'000, .min_expected = 10}));
}

// The weight has the profile's sign at the sample and a constant magnitude.
TEST_P(EveryFilter, WeightsAreSignedAndAverageToOne) {
  const FilterEntry& e = entry();
  const PixelFilter f = filter();
  const double integral = integrate([&](double x) { return e.profile(x); });
  const double magnitude = integrate([&](double x) { return std::abs(e.profile(x)); });
  const double size = square(magnitude / integral);
  // With stratified u, an n x n grid gives the exact mean, except in strips that straddle a sign
  // change.
  constexpr int kGrid = 1024;
  double sum = 0;
  for (int y = 0; y < kGrid; ++y) {
    for (int x = 0; x < kGrid; ++x) {
      const FilterSample s = f.sample({(float(x) + 0.5f) / kGrid, (float(y) + 0.5f) / kGrid});
      sum += s.weight;
      ASSERT_NEAR(std::abs(s.weight), size, 1e-4);
      const double product =
          e.profile(s.offset.x / e.default_radius) * e.profile(s.offset.y / e.default_radius);
      if (std::abs(product) > 1e-6) {
        ASSERT_EQ(s.weight > 0, product > 0) << s.offset;
      }
    }
  }
  const bool non_negative = std::abs(size - 1.0) < 1e-9;
  EXPECT_NEAR(sum / (kGrid * kGrid), 1.0, non_negative ? 1e-6 : 4.0 / kGrid);
  if (non_negative) {
    EXPECT_EQ(f.sample({0.3f, 0.7f}).weight, 1.0f);
  }
}

// Every filter reproduces a linear ramp across the frame: E[w (a + b x + c y)] = a. The second
// moment is that of the profile, so the blur has the right width.
TEST_P(EveryFilter, ReconstructsALinearRamp) {
  const FilterEntry& e = entry();
  const PixelFilter f = filter();
  constexpr int kGrid = 2048;
  double ramp = 0, second = 0;
  for (int y = 0; y < kGrid; ++y) {
    for (int x = 0; x < kGrid; ++x) {
      // The shift by half a cell keeps grid lines off the sign changes, so that strips are split
      // evenly.
      const FilterSample s = f.sample({(float(x) + 0.5f) / kGrid, (float(y) + 0.5f) / kGrid});
      ramp += s.weight * (2.0 * s.offset.x - 3.0 * s.offset.y);
      second += s.weight * s.offset.x * s.offset.x;
    }
  }
  EXPECT_NEAR(ramp / (kGrid * double(kGrid)), 0.0, 1e-6);
  const double exact = square(e.default_radius) *
                       integrate([&](double x) { return x * x * e.profile(x); }) /
                       integrate([&](double x) { return e.profile(x); });
  EXPECT_NEAR(second / (kGrid * double(kGrid)), exact, 2e-3);
}

// The samples that count for a pixel, weighted by its shares in them, have the same expectation as
// the pixel's own weighted samples. This holds at a smooth place, at an edge, and for the weights
// alone.
TEST_P(EveryFilter, SharesOfNeighboursMakeThePixel) {
  constexpr int kGrid = 2048;
  for (const float radius : {entry().default_radius, 0.7f}) {
    const PixelFilter f = PixelFilter::create(GetParam(), radius);
    const auto light = [](const Vec2f& at) {
      const bool beyond = at.x + 0.37f * at.y > 0.21f;
      return std::array{1.0, double(at.x) + double(at.x) * double(at.y), beyond ? 5.0 : 0.5};
    };
    std::array<double, 3> own = {}, shared = {};
    for (int y = 0; y < kGrid; ++y) {
      for (int x = 0; x < kGrid; ++x) {
        const FilterSample s = f.sample({(float(x) + 0.5f) / kGrid, (float(y) + 0.5f) / kGrid});
        const SampleShares shares = f.shares(s.offset);
        const auto here = light(s.offset);
        for (size_t i = 0; i < 3; ++i) own[i] += double(s.weight) * here[i];
        for (size_t k = 0; k < kSharedPixels; ++k) {
          // The pixel gets share k of a sample from the neighbour on the side opposite to k.
          const Vec2f from = {1.0f - float(k % 3), 1.0f - float(k / 3)};
          const auto there = light(from + s.offset);
          for (size_t i = 0; i < 3; ++i) shared[i] += double(shares[k]) * there[i];
        }
      }
    }
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(shared[i] / (kGrid * kGrid), own[i] / (kGrid * kGrid), 6e-3)
          << radius << ", " << i;
    }
  }
}

TEST(PixelFilterBox, SharesNothingOfThePixelsOwn) {
  const SampleShares shares = PixelFilter::create("box").shares({0.3f, -0.4f});
  for (size_t k = 0; k < kSharedPixels; ++k) EXPECT_EQ(shares[k], k == 4 ? 1.0f : 0.0f) << k;
}

// With the sobol sampler a filtered edge converges faster than Monte Carlo, because the maps keep
// the stratification. 400 pixels determine each variance to 7 %. Random sampling would give a ratio
// of 16.
TEST_P(EveryFilter, KeepsStratification) {
  const PixelFilter f = filter();
  const auto sampler = create_sampler("sobol", {});
  const auto error = [&](uint32_t count) {
    double sum = 0;
    for (uint32_t p = 0; p < 400; ++p) {
      double positive = 0, all = 0;
      for_each_sample(*sampler, {p, 2, 3}, 0, count, [&](uint32_t, const SlotNumbers& n) {
        const FilterSample s = f.sample({n.u[0], n.u[1]});
        if (2 * s.offset.x + s.offset.y > 0) positive += s.weight;
        all += s.weight;
      });
      sum += square(positive / count - 0.5);
    }
    return sum / 400;
  };
  EXPECT_GT(error(64) / error(1024), 32.0);
}

TEST(PixelFilterClosedForms, Normalisation) {
  const auto entries = filter_table();
  const auto integral = [&](size_t i) { return 2 * integrate(entries[i].profile); };
  ASSERT_EQ(entries[0].name, "box");
  EXPECT_NEAR(integral(0), 2.0, 1e-12);
  ASSERT_EQ(entries[1].name, "gaussian");  // integral of exp(-4.5 x^2) - exp(-4.5) on [-1, 1]
  EXPECT_NEAR(integral(1), std::sqrt(kPiD / 4.5) * std::erf(std::sqrt(4.5)) - 2 * std::exp(-4.5),
              1e-9);
  ASSERT_EQ(entries[2].name, "blackman-harris");  // the cosines integrate to zero
  EXPECT_NEAR(integral(2), 2 * 0.35875, 1e-9);
  EXPECT_NEAR(entries[2].profile(0), 1.0, 1e-12);
  ASSERT_EQ(entries[3].name,
            "mitchell");  // unit integral over [-2, 2]: 1/2 with the radius as unit
  EXPECT_NEAR(integral(3), 0.5, 1e-9);
}

// Compares with Mitchell's cubic in its published form, with B = C = 1/3.
TEST(PixelFilterClosedForms, MitchellAgreesWithThePaper) {
  constexpr double kB = 1.0 / 3, kC = 1.0 / 3;
  for (int i = 0; i <= 1000; ++i) {
    const double t = 2.0 * i / 1000;
    const double inner =
        (12 - 9 * kB - 6 * kC) * t * t * t + (-18 + 12 * kB + 6 * kC) * t * t + (6 - 2 * kB);
    const double outer = (-kB - 6 * kC) * t * t * t + (6 * kB + 30 * kC) * t * t +
                         (-12 * kB - 48 * kC) * t + (8 * kB + 24 * kC);
    EXPECT_NEAR(filter_table()[3].profile(t / 2), (t < 1 ? inner : outer) / 6, 1e-12) << t;
  }
}

TEST(PixelFilterBox, IsExactlyThePixel) {
  const PixelFilter f = PixelFilter::create("box");
  for (uint32_t i = 0; i < 10000; ++i) {
    const Vec2f u = random_point(i);
    const FilterSample s = f.sample(u);
    ASSERT_EQ(s.offset, u - Vec2f(0.5f));
    ASSERT_EQ(s.weight, 1.0f);
  }
}

// Computes the mean weight without sampling noise, from the shares of u on both sides of the sign
// change. Mitchell's radius is 2 pixels, and the sign changes at 8/7 pixels. Bisection finds the u
// for it.
TEST(PixelFilterClosedForms, MitchellWeightsAverageToOne) {
  const PixelFilter f = PixelFilter::create("mitchell");
  float low = 0.5f, high = 1.0f;
  while (high - low > 0x1p-23f) {
    const float middle = 0.5f * (low + high);
    (f.sample({middle, 0.5f}).offset.x < 8.0f / 7.0f ? low : high) = middle;
  }
  const double positive = 2.0 * double(low) - 1.0;
  const double weight = std::sqrt(double(f.sample({0.5f, 0.5f}).weight));
  EXPECT_NEAR(weight * (positive - (1.0 - positive)), 1.0, 1e-6);
  // A negative lobe is 7/18 s^2 (d - s) with s = 2 - t and d = 6/7. Its integral is 7/18 d^4 / 12.
  // With two such lobes, the integral of the absolute value is 1 + 4 * 7/18 d^4 / 12.
  const double d = 6.0 / 7.0;
  EXPECT_NEAR(weight, 1.0 + 4.0 * 7.0 / 18.0 * d * d * d * d / 12.0, 2e-5);
}

TEST(PixelFilterErrors, NamesAndRadii) {
  try {
    PixelFilter::create("gausian");
    FAIL() << "accepted an unknown name";
  } catch (const UsageError& error) {
    EXPECT_STREQ(
        error.what(),
        "filter: unknown filter 'gausian' (did you mean 'gaussian'?); valid names are box, "
        "gaussian, blackman-harris, mitchell");
  }
  for (const float radius : {0.0f, -1.0f, 33.0f, NAN, INFINITY}) {
    EXPECT_THROW(PixelFilter::create("box", radius), UsageError) << radius;
  }
}

}  // namespace
}  // namespace emberline
