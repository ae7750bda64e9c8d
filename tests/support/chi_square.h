// The chi-square harness for all sampling routines. A sampling routine maps random numbers to
// points and reports the density of these points. The harness tests whether the points have that
// density.
//
//   EXPECT_TRUE(chi_square_directions(
//       [&](TestRandom& random) { return std::optional(square_to_cosine_hemisphere(random.vec2()));
//       },
//       [](const Vec3f& w) { return double(test::square_to_cosine_hemisphere_pdf(w)); }));
//
// The harness divides the domain into bins and integrates the density adaptively over each bin.
// Then it draws many samples, and computes a p-value from Pearson's statistic over the bins. Bins
// with fewer than `min_expected` expected draws are pooled. A routine may reject a sample
// (std::nullopt). The mass that is missing from the density is then one more bin. Seeds are fixed,
// so failures are repeatable, and the message says which draws to repeat. The design follows the
// chi-square tests of Mitsuba 2 (Nimier-David et al. 2019).
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/hash.h"
#include "renderer/core/vector.h"
#include "support/long_tests.h"

namespace emberline::test {

// The random numbers of one draw. They depend only on the seed and on the number of the draw, so
// any single draw can be repeated.
class TestRandom {
 public:
  TestRandom(uint64_t seed, uint64_t draw) : state_(hash_combine64(hash64(seed + 1), draw)) {}
  uint32_t bits() { return uint32_t(hash64(state_ += 0x9e3779b97f4a7c15ull) >> 32); }
  float next() { return to_unit_float(bits()); }  // uniform in [0, 1)
  Vec2f vec2() {
    const float x = next();
    return {x, next()};
  }
  double next_double() {
    const uint64_t high = bits();
    return double((high << 21) ^ (bits() >> 11)) * 0x1p-53;
  }

 private:
  uint64_t state_;
};

// A sampled point of the parameter domain. If weights differ from 1, the test compares the weighted
// histogram with the density. For instance, the samples of a BSDF, weighted by value over density,
// must have a histogram that follows the value of the BSDF.
struct ChiSquarePoint {
  double x = 0, y = 0;
  double weight = 1;
};

struct ChiSquareDomain {
  double x0 = 0, x1 = 1, y0 = 0, y1 = 1;
};

struct ChiSquareSettings {
  int bins_x = 16, bins_y = 32;
  // Short tests draw a quarter of this number. 400,000 samples in 512 bins detect a density that is
  // 2 % too high in half of the bins and 2 % too low in the other half; 100,000 samples detect 4 %.
  // If the integral of the density exceeds 1 by 1e-3, the test fails with any samples.
  uint64_t samples = 400'000;
  uint64_t seed = 1;
  // The probability that at least one of `tests` correct routines fails. The limit on the p-value
  // of each routine follows from this (Sidak 1967).
  double false_alarm = 1e-6;
  int tests = 1;
  double min_expected = 5;  // bins with fewer expected draws are pooled (Cochran 1954)
  // The fraction of the draws whose reported density may be 0, because rounding moves some points
  // beyond the edge of the support.
  double zero_density_fraction = 1e-4;
};

using ChiSquareSampler = std::function<std::optional<ChiSquarePoint>(TestRandom&)>;
using ChiSquareDensity = std::function<double(double x, double y)>;

// The regularised upper incomplete gamma function Q(a, x). The p-value of chi-square with k degrees
// of freedom is Q(k / 2, statistic / 2). Uses the series DLMF 8.11.4 for x < a + 1, and otherwise
// the continued fraction DLMF 8.9.2 (modified Lentz).
inline double gamma_q(double a, double x) {
  if (!(x > 0)) return 1;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < 100000 && term > sum * 1e-16; ++n) sum += term *= x / (a + n);
    return std::max(0.0, 1 - front * sum);
  }
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
  for (int n = 1; n < 100000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    c = b + an / c;
    if (std::abs(d) < kTiny) d = kTiny;
    if (std::abs(c) < kTiny) c = kTiny;
    d = 1 / d;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return front * h;
}

inline double chi_square_p_value(double statistic, int degrees) {
  return gamma_q(degrees / 2.0, statistic / 2.0);
}

// Integrates `f` over a rectangle with 3x3 Gauss-Legendre nodes. Halves the rectangle in both
// directions until the sum over the four parts agrees with the integral over the whole. If `f` is
// discontinuous, `depth` determines the error.
inline double integrate_rectangle(const ChiSquareDensity& f, const ChiSquareDomain& r,
                                  double tolerance, int depth = 9) {
  const auto rule = [&f](double x0, double x1, double y0, double y1) {
    static const double kNode[3] = {-std::sqrt(0.6), 0, std::sqrt(0.6)};
    static const double kWeight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum +=
            kWeight[i] * kWeight[j] *
            f((x0 + x1) / 2 + (x1 - x0) / 2 * kNode[i], (y0 + y1) / 2 + (y1 - y0) / 2 * kNode[j]);
    return sum * (x1 - x0) * (y1 - y0);
  };
  const std::function<double(double, double, double, double, double, double, int)> refine =
      [&](double x0, double x1, double y0, double y1, double whole, double limit, int left) {
        const double xm = (x0 + x1) / 2, ym = (y0 + y1) / 2;
        const double a = rule(x0, xm, y0, ym), b = rule(xm, x1, y0, ym);
        const double c = rule(x0, xm, ym, y1), d = rule(xm, x1, ym, y1);
        const double sum = a + b + c + d;
        if (left <= 0 || std::abs(sum - whole) <= limit) return sum;
        return refine(x0, xm, y0, ym, a, limit / 2, left - 1) +
               refine(xm, x1, y0, ym, b, limit / 2, left - 1) +
               refine(x0, xm, ym, y1, c, limit / 2, left - 1) +
               refine(xm, x1, ym, y1, d, limit / 2, left - 1);
      };
  // Always split the rectangle once, because a narrow support could lie between its nine nodes.
  const double xm = (r.x0 + r.x1) / 2, ym = (r.y0 + r.y1) / 2;
  const double cuts[4][4] = {
      {r.x0, xm, r.y0, ym}, {xm, r.x1, r.y0, ym}, {r.x0, xm, ym, r.y1}, {xm, r.x1, ym, r.y1}};
  double total = 0;
  for (const auto& q : cuts)
    total += refine(q[0], q[1], q[2], q[3], rule(q[0], q[1], q[2], q[3]), tolerance / 4, depth - 1);
  return total;
}

// Tests that `sample` draws points of `domain` with `density` (per unit of the domain's area).
inline ::testing::AssertionResult chi_square_test(const ChiSquareSampler& sample,
                                                  const ChiSquareDensity& density,
                                                  const ChiSquareDomain& domain = {},
                                                  const ChiSquareSettings& settings = {}) {
  const int nx = settings.bins_x, ny = settings.bins_y;
  const uint64_t draws = settings.samples / long_or_short(1, 4);
  const double n = double(draws);
  const double wx = (domain.x1 - domain.x0) / nx, wy = (domain.y1 - domain.y0) / ny;
  std::ostringstream where;
  if (const auto* info = ::testing::UnitTest::GetInstance()->current_test_info())
    where << "replay: --gtest_filter=" << info->test_suite_name() << "." << info->name() << ", ";
  where << "TestRandom(" << settings.seed << ", draw), draw < " << draws << ", " << nx << "x" << ny
        << " bins";
  const auto failure = [&where] { return ::testing::AssertionFailure() << where.str() << "\n"; };

  std::vector<double> sum(size_t(nx) * ny), squares(sum.size()), expected(sum.size());
  bool weighted = false;
  uint64_t zero_density = 0, first_zero = 0;
  double inside = 0;
  for (uint64_t draw = 0; draw < draws; ++draw) {
    TestRandom random(settings.seed, draw);
    const std::optional<ChiSquarePoint> p = sample(random);
    if (!p) continue;
    const double slack = 1e-6;  // how far rounding may move points outside, as part of the width
    const double fx = (p->x - domain.x0) / (domain.x1 - domain.x0);
    const double fy = (p->y - domain.y0) / (domain.y1 - domain.y0);
    if (!(fx >= -slack && fx <= 1 + slack && fy >= -slack && fy <= 1 + slack) ||
        !std::isfinite(p->weight))
      return failure() << "draw " << draw << " gave (" << p->x << ", " << p->y << ") weight "
                       << p->weight << ", outside the domain or not finite";
    const double d = density(p->x, p->y);
    if (!(d >= 0) || !std::isfinite(d))
      return failure() << "draw " << draw << " at (" << p->x << ", " << p->y << ") has density "
                       << d;
    if (d == 0 && p->weight != 0 && zero_density++ == 0) first_zero = draw;
    const int bx = std::clamp(int(fx * nx), 0, nx - 1), by = std::clamp(int(fy * ny), 0, ny - 1);
    const size_t bin = size_t(by) * nx + bx;
    sum[bin] += p->weight;
    squares[bin] += p->weight * p->weight;
    weighted |= p->weight != 1;
    inside += 1;
  }
  if (double(zero_density) > settings.zero_density_fraction * n)
    return failure() << zero_density << " draws have density 0; the first is draw " << first_zero;

  double mass = 0;
  for (int by = 0; by < ny; ++by)
    for (int bx = 0; bx < nx; ++bx) {
      const ChiSquareDomain r{domain.x0 + bx * wx, domain.x0 + (bx + 1) * wx, domain.y0 + by * wy,
                              domain.y0 + (by + 1) * wy};
      // The integral may have an error of a hundredth of the standard deviation of a bin's count,
      // which does not affect the statistic.
      const double tolerance = 0.01 * std::sqrt(std::max(1.0, n / (double(nx) * ny))) / n;
      const double e = integrate_rectangle(density, r, tolerance);
      if (!(e >= 0) || !std::isfinite(e))
        return failure() << "the density is negative or not finite";
      expected[size_t(by) * nx + bx] = n * e;
      mass += e;
    }
  if (!weighted && mass > 1 + 1e-3)
    return failure() << "the density integrates to " << mass << " > 1";

  double statistic = 0;
  int degrees = 0;
  size_t worst = 0;
  double worst_term = -1;
  if (!weighted) {
    double pooled_expected = 0, pooled_observed = 0;
    const auto add = [&](double e, double o) {
      statistic += square(o - e) / e;
      ++degrees;
    };
    const double expected_rejected = std::max(0.0, n * (1 - mass));  // in draws
    if (expected_rejected >= settings.min_expected)
      add(expected_rejected, n - inside);
    else
      pooled_expected += expected_rejected, pooled_observed += n - inside;
    for (size_t i = 0; i < sum.size(); ++i) {
      const double term = square(sum[i] - expected[i]) / std::max(expected[i], 1.0);
      if (term > worst_term) worst_term = term, worst = i;
      if (expected[i] >= settings.min_expected) {
        add(expected[i], sum[i]);
      } else {
        pooled_expected += expected[i];
        pooled_observed += sum[i];
      }
    }
    if (pooled_expected >= settings.min_expected) {
      add(pooled_expected, pooled_observed);
    } else if (pooled_observed > 0) {
      // The pool has too little mass for a term of the statistic, so the tail of a Poisson
      // distribution decides whether it has too many draws. Rounding may put one draw in a million
      // into a wrong bin.
      const double p = 1 - gamma_q(pooled_observed, pooled_expected + 1e-6 * n);
      if (p < settings.false_alarm / 2)
        return failure() << pooled_observed << " draws where " << pooled_expected
                         << " are expected in total";
    }
    --degrees;  // the counts add up to n
  } else {
    // The weighted sums of the bins are not multinomial. Their covariance matrix is
    // n (diag(s) - e e^T), where s is the second moment of the weights in a bin, and e is the mass
    // of the bin. The matrix is inverted as in Sherman & Morrison 1950. Bins with few draws are
    // skipped, because their sums are far from normally distributed.
    double de = 0, ee = 0;
    for (size_t i = 0; i < sum.size(); ++i) {
      const double e = expected[i] / n, s = squares[i] / n, d = (sum[i] - expected[i]) / n;
      const double effective = squares[i] > 0 ? square(sum[i]) / squares[i] : 0;
      if (effective < 50) continue;
      const double term = n * d * d / s;
      if (term > worst_term) worst_term = term, worst = i;
      statistic += term;
      de += d * e / s;
      ee += e * e / s;
      ++degrees;
    }
    // The moments s are estimates. If the weights are nearly equal, ee is 1 except for noise, and
    // the last term of the inverse would divide noise by noise. This term is positive, so skipping
    // it causes no false alarm.
    if (ee < 0.9)
      statistic += n * de * de / (1 - ee);
    else
      --degrees;
  }
  if (degrees < 1) return failure() << "one bin holds everything: nothing was tested";

  const double p_value = chi_square_p_value(statistic, degrees);
  const double limit = -std::expm1(std::log1p(-settings.false_alarm) / std::max(1, settings.tests));
  if (std::isfinite(statistic) && p_value >= limit) return ::testing::AssertionSuccess();
  const int bx = int(worst % size_t(nx)), by = int(worst / size_t(nx));
  return failure() << "chi-square " << statistic << " with " << degrees
                   << " degrees of freedom: p = " << p_value << " < " << limit
                   << "; the density integrates to " << mass << ", " << inside / n
                   << " of the draws were kept; worst bin x [" << domain.x0 + bx * wx << ", "
                   << domain.x0 + (bx + 1) * wx << "], y [" << domain.y0 + by * wy << ", "
                   << domain.y0 + (by + 1) * wy << "]: " << sum[worst] << " drawn, "
                   << expected[worst] << " expected";
}

// Tests a routine that samples directions. The domain is (cos theta, phi) around +Z, in which areas
// are solid angles. `density` is per solid angle. With z_min = 0, the domain is only the upper
// hemisphere.
inline ::testing::AssertionResult chi_square_directions(
    const std::function<std::optional<Vec3f>(TestRandom&)>& sample,
    const std::function<double(const Vec3f&)>& density, const ChiSquareSettings& settings = {},
    double z_min = -1) {
  return chi_square_test(
      [&](TestRandom& random) -> std::optional<ChiSquarePoint> {
        const std::optional<Vec3f> w = sample(random);
        if (!w) return std::nullopt;
        // chi_square_test() reports a NaN point as outside the domain.
        if (std::abs(dot(*w, *w) - 1.0f) > 1e-4f)
          return ChiSquarePoint{std::numeric_limits<double>::quiet_NaN(), 0, 1};
        double phi = std::atan2(double(w->y), double(w->x));
        if (phi < 0) phi += 2 * kPiD;
        return ChiSquarePoint{double(w->z), phi, 1};
      },
      [&](double z, double phi) {
        z = std::clamp(z, -1.0, 1.0);
        const double r = std::sqrt((1 - z) * (1 + z));
        return density(Vec3f(float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)));
      },
      {z_min, 1, 0, 2 * kPiD}, settings);
}

}  // namespace emberline::test
