// Tests every warp of renderer/core/warps.h: its pdf by chi-square, its inverse by a round trip,
// and its values at the edges of u.
#include "renderer/core/warps.h"

#include <gtest/gtest.h>

#include "support/chi_square.h"
#include "support/warp_inverses.h"

namespace emberline {
namespace {

using test::ChiSquareDomain;
using test::ChiSquarePoint;
using test::ChiSquareSettings;
using test::TestRandom;

constexpr int kTests = 8;  // chi-square tests in this file, for the family's false-alarm rate

ChiSquareSettings settings(uint64_t seed) {
  ChiSquareSettings s;
  s.seed = seed;
  s.tests = kTests;
  return s;
}

// Values of u at the corners and edges, followed by random values.
std::vector<Vec2f> probes() {
  std::vector<Vec2f> result;
  const float edges[] = {0.0f, 0x1p-24f, 0.25f, 0.5f, 0.75f, kOneMinusEpsilon};
  for (float x : edges)
    for (float y : edges) result.push_back({x, y});
  for (uint64_t draw = 0; draw < 20000; ++draw) result.push_back(TestRandom(77, draw).vec2());
  return result;
}

// The distance between two coordinates that stand for an angle, so that 0 and 1 coincide.
float wrapped(float a, float b) { return std::min(std::abs(a - b), 1 - std::abs(a - b)); }

TEST(Warps, DiskHasItsDensity) {
  EXPECT_TRUE(test::chi_square_test(
      [](TestRandom& r) -> std::optional<ChiSquarePoint> {
        const Vec2f p = square_to_disk(r.vec2());
        return ChiSquarePoint{p.x, p.y, 1};
      },
      [](double x, double y) { return test::square_to_disk_pdf(Vec2f(float(x), float(y))); },
      ChiSquareDomain{-1, 1, -1, 1}, settings(1)));
}

TEST(Warps, DiskInverts) {
  for (const Vec2f& u : probes()) {
    const Vec2f p = square_to_disk(u);
    ASSERT_LE(p.dot(p), 1 + 1e-6f);
    const Vec2f back = test::disk_to_square(p);
    ASSERT_NEAR(back.x, u.x, 2e-6f) << u;
    ASSERT_NEAR(back.y, u.y, 2e-6f) << u;
  }
}

TEST(Warps, CosineHemisphereHasItsDensity) {
  EXPECT_TRUE(test::chi_square_directions(
      [](TestRandom& r) { return std::optional(square_to_cosine_hemisphere(r.vec2())); },
      [](const Vec3f& w) { return double(test::square_to_cosine_hemisphere_pdf(w)); },
      settings(2)));
}

TEST(Warps, CosineHemisphereInvertsAndStaysAbovePlane) {
  for (const Vec2f& u : probes()) {
    const Vec3f w = square_to_cosine_hemisphere(u);
    ASSERT_GT(w.z, 0) << u;
    ASSERT_GT(test::square_to_cosine_hemisphere_pdf(w), 0) << u;
    ASSERT_NEAR(dot(w, w), 1, 1e-6f) << u;
    const Vec2f back = test::cosine_hemisphere_to_square(w);
    ASSERT_NEAR(back.x, u.x, 2e-6f) << u;
    ASSERT_NEAR(back.y, u.y, 2e-6f) << u;
  }
}

TEST(Warps, SphereHasItsDensity) {
  EXPECT_TRUE(test::chi_square_directions(
      [](TestRandom& r) { return std::optional(square_to_sphere(r.vec2())); },
      [](const Vec3f& w) { return double(square_to_sphere_pdf(w)); }, settings(3)));
}

TEST(Warps, SphereInverts) {
  for (const Vec2f& u : probes()) {
    const Vec3f w = square_to_sphere(u);
    ASSERT_NEAR(dot(w, w), 1, 1e-6f) << u;
    const Vec2f back = test::sphere_to_square(w);
    ASSERT_NEAR(back.x, u.x, 1e-6f) << u;
    if (u.x == 0) continue;  // phi is arbitrary at the pole
    ASSERT_LT(wrapped(back.y, u.y), 1e-6f) << u;
  }
}

TEST(Warps, TriangleIsUniform) {
  EXPECT_TRUE(test::chi_square_test(
      [](TestRandom& r) -> std::optional<ChiSquarePoint> {
        const Vec2f b = square_to_triangle(r.vec2());
        return ChiSquarePoint{b.x, b.y, 1};
      },
      [](double x, double y) { return x + y <= 1 ? 2.0 : 0.0; }, {}, settings(8)));
}

TEST(Warps, TriangleInvertsAndStaysInside) {
  for (const Vec2f& u : probes()) {
    const Vec2f b = square_to_triangle(u);
    ASSERT_GE(b.x, 0) << u;
    ASSERT_GE(b.y, 0) << u;
    ASSERT_LE(b.x + b.y, 1) << u;
    const Vec2f back = test::triangle_to_square(b);
    ASSERT_NEAR(back.x, u.x, 2e-7f) << u;
    ASSERT_NEAR(back.y, u.y, 2e-7f) << u;
  }
}

// The harness must be able to fail: it detects a pdf that is 5 % too high on one half and 5 % too
// low on the other half.
TEST(ChiSquare, FindsAWrongDensity) {
  const auto uniform = [](TestRandom& r) -> std::optional<ChiSquarePoint> {
    return ChiSquarePoint{r.next(), r.next(), 1};
  };
  EXPECT_TRUE(test::chi_square_test(uniform, [](double, double) { return 1.0; }));
  EXPECT_FALSE(
      test::chi_square_test(uniform, [](double x, double) { return x < .5 ? 1.05 : .95; }));
  EXPECT_FALSE(test::chi_square_test(uniform, [](double, double) { return 0.9; }));
  EXPECT_FALSE(test::chi_square_test(uniform, [](double, double) { return 1.1; }));
}

// The rejected samples account for the mass that the pdf lacks.
TEST(ChiSquare, AccountsForRefusedDraws) {
  const auto half = [](TestRandom& r) -> std::optional<ChiSquarePoint> {
    const Vec2f u = r.vec2();
    if (u.x < 0.5f) return std::nullopt;
    return ChiSquarePoint{u.x, u.y, 1};
  };
  EXPECT_TRUE(test::chi_square_test(half, [](double x, double) { return x < .5 ? 0.0 : 1.0; }));
  EXPECT_FALSE(test::chi_square_test(half, [](double x, double) { return x < .5 ? 0.0 : 2.0; }));
}

TEST(ChiSquare, ComparesWeightsWithAFunction) {
  const auto weighted = [](TestRandom& r) -> std::optional<ChiSquarePoint> {
    const Vec2f u = r.vec2();
    return ChiSquarePoint{u.x, u.y, 3.0 * u.x * u.x};
  };
  EXPECT_TRUE(test::chi_square_test(weighted, [](double x, double) { return 3 * x * x; }));
  // A short run has a quarter of the draws, so its error is twice as large.
  const double wrong = test::long_or_short(3.1, 3.2);
  EXPECT_FALSE(test::chi_square_test(weighted, [=](double x, double) { return wrong * x * x; }));
  EXPECT_FALSE(test::chi_square_test(weighted, [](double x, double) { return 2 * x; }));
}

// The quantiles are those of Abramowitz & Stegun, table 26.8.
TEST(ChiSquare, PValuesMatchTables) {
  EXPECT_NEAR(test::chi_square_p_value(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(test::chi_square_p_value(18.3070, 10), 0.05, 1e-6);
  EXPECT_NEAR(test::chi_square_p_value(15.9872, 10), 0.1, 1e-6);
  EXPECT_NEAR(test::chi_square_p_value(29.5883, 10), 0.001, 1e-7);
  EXPECT_NEAR(test::chi_square_p_value(77.9295, 100), 0.95, 1e-6);
  EXPECT_NEAR(test::chi_square_p_value(149.449, 100), 0.001, 1e-7);
  EXPECT_NEAR(test::chi_square_p_value(2.0, 2), std::exp(-1.0), 1e-14);
}

}  // namespace
}  // namespace emberline
