// Tests the single wavelength of a path: its weights, and its index of refraction.
#include "renderer/shading/lobes/wavelength.h"

#include <gtest/gtest.h>

#include "renderer/shading/lobes/colour_matching.h"
#include "support/chi_square.h"

namespace emberline {
namespace {

// Compares the fit with the standard's table at 20 nm (CIE 15:2018, table 1).
TEST(Wavelength, MatchingFunctionsMatchTheStandard) {
  const double table[][4] = {
      {400, .01431, .000396, .06785}, {420, .13438, .0040, .6456},   {440, .34828, .0230, 1.74706},
      {460, .2908, .0600, 1.6692},    {480, .09564, .13902, .81295}, {500, .0049, .3230, .2720},
      {520, .06327, .7100, .07825},   {540, .2904, .9540, .0203},    {560, .5945, .9950, .0039},
      {580, .9163, .8700, .00165},    {600, 1.0622, .6310, .0008},   {620, .85445, .3810, .00019},
      {640, .4479, .1750, .00002},    {660, .1649, .0610, 0},        {680, .04677, .0170, 0}};
  for (const auto& [nanometres, x, y, z] : table) {
    const Vec3d fit = cie_1931(nanometres);
    EXPECT_NEAR(fit.x, x, .035) << nanometres;
    EXPECT_NEAR(fit.y, y, .025) << nanometres;
    EXPECT_NEAR(fit.z, z, .065) << nanometres;
  }
}

TEST(Wavelength, MeanWeightIsWhite) {
  Vec3d sum(0.0);
  const int n = 1 << 20;
  for (int i = 0; i < n; ++i) {
    const SampledWavelength s = sample_wavelength(float((i + .5) / n));
    sum += to_double(s.weight);
    ASSERT_GE(std::min({s.weight.x, s.weight.y, s.weight.z}), 0);
    ASSERT_LE(max_component(s.weight), 3.0001f);
    // All samples have the same total weight, which keeps luminance noise low.
    ASSERT_NEAR(s.weight.x + s.weight.y + s.weight.z, 3, 1e-5);
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / n, 1, 1e-5) << c;
}

TEST(Wavelength, IncreasesWithU) {
  float last = 0;
  for (int i = 0; i <= 1 << 16; ++i) {
    const float u = std::min(float(i) * 0x1p-16f, kOneMinusEpsilon);
    const SampledWavelength s = sample_wavelength(u);
    ASSERT_TRUE(s.nanometres >= 380 && s.nanometres <= 700 && is_finite(s.weight)) << u;
    ASSERT_GE(s.nanometres, last) << u;
    if (i > 16 && i < (1 << 16) - 16) {
      ASSERT_LT(s.nanometres - last, .6f) << u;  // no jumps
    }
    last = s.nanometres;
  }
}

// The pdf is the mean of the responses, and the weights are the responses divided by it.
TEST(Wavelength, FollowsTheResponses) {
  Vec3d integral(0.0);
  const auto cut = [](double nanometres) {
    const Vec3d r = rec709_response(nanometres);
    return Vec3d(std::max(r.x, 0.0), std::max(r.y, 0.0), std::max(r.z, 0.0));
  };
  for (int i = 0; i < 3200; ++i) integral += cut(380 + (i + .5) * .1) * .1;
  const auto density = [&](double x) {
    const Vec3d r = cut(x);
    return (r.x / integral.x + r.y / integral.y + r.z / integral.z) / 3;
  };
  EXPECT_TRUE(test::chi_square_test(
      [](test::TestRandom& random) -> std::optional<test::ChiSquarePoint> {
        return test::ChiSquarePoint{double(sample_wavelength(random.next()).nanometres),
                                    random.next_double(), 1};
      },
      [&](double x, double) { return density(x); }, {380, 700, 0, 1},
      {.bins_x = 160, .bins_y = 1, .samples = 200'000, .seed = 31}));
  for (float u = .05f; u < 1; u += .05f) {
    const SampledWavelength s = sample_wavelength(u);
    const Vec3d r = cut(double(s.nanometres));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(double(s.weight[c]), r[c] / integral[c] / density(double(s.nanometres)), .02)
          << s.nanometres;
  }
}

TEST(Wavelength, IndicesMeetTheAbbeNumber) {
  for (const float ior : {1.0f, 1.33f, 1.5f, 1.77f, 2.42f})
    for (const float dispersion : {.1f, .36f, 1.0f, 2.04f}) {
      const float f = ior_at(ior, dispersion, 486.13f), c = ior_at(ior, dispersion, 656.27f);
      EXPECT_NEAR(f - c, (ior - 1) * dispersion / 20, 1e-6f);
      EXPECT_NEAR(ior_at(ior, dispersion, 587.56f), ior, 2e-7f * ior);
      // The extension gives this form with rounded numbers.
      for (const float nanometres : {400.0f, 550.0f, 700.0f})
        EXPECT_NEAR(ior_at(ior, dispersion, nanometres),
                    ior + (ior - 1) * dispersion / 20 * (523655 / square(nanometres) - 1.5168f),
                    1e-5f);
    }
  for (float nanometres = 380; nanometres <= 780; nanometres += 10) {
    EXPECT_EQ(ior_at(1.5f, 0, nanometres), 1.5f);
    EXPECT_EQ(ior_at(0, 1, nanometres), 0);  // a dielectric that reflects everything stays one
    EXPECT_GE(ior_at(1.1f, 50, nanometres), 1);
  }
}

}  // namespace
}  // namespace emberline
