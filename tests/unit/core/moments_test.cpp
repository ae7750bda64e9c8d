#include "renderer/core/moments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "renderer/core/hash.h"

namespace emberline {
namespace {

std::vector<double> numbers(uint32_t count, double offset, double scale) {
  std::vector<double> result(count);
  for (uint32_t i = 0; i < count; ++i) result[i] = offset + scale * to_unit_float(hash32(i));
  return result;
}

struct Reference {
  long double mean = 0, variance = 0;
};
// Computes the moments the simple way, with two passes in long double.
Reference two_pass(const std::vector<double>& xs) {
  Reference r;
  for (const double x : xs) r.mean += x;
  r.mean /= xs.size();
  for (const double x : xs) r.variance += (x - r.mean) * (x - r.mean);
  r.variance /= xs.size() - 1;
  return r;
}

Moments running(const std::vector<double>& xs, size_t begin, size_t end) {
  Moments m;
  for (size_t i = begin; i < end; ++i) m.add(xs[i]);
  return m;
}

// A naive sum of squares fails with a large offset: at 1e9 it has no correct digit left.
TEST(Moments, AgreeWithTwoPasses) {
  for (const double offset : {0.0, 1.0, -1e4, 1e9}) {
    for (const double scale : {1e-3, 1.0, 1e6}) {
      const std::vector<double> xs = numbers(10001, offset, scale);
      const Reference expected = two_pass(xs);
      const Moments m = running(xs, 0, xs.size());
      EXPECT_EQ(m.count(), xs.size());
      EXPECT_NEAR(m.mean(), double(expected.mean), 1e-13 * (std::abs(offset) + scale));
      // Rounding errors grow with the offset, so the variance becomes less accurate.
      const double known = 1e-12 + 1e-14 * std::abs(offset) / scale;
      EXPECT_NEAR(m.variance() / double(expected.variance), 1.0, known) << offset << " " << scale;
      EXPECT_DOUBLE_EQ(m.standard_error(), std::sqrt(m.variance() / 10001.0));
    }
  }
}

TEST(Moments, MergeEqualsOnePass) {
  const std::vector<double> xs = numbers(5000, 3.0, 2.0);
  const Reference expected = two_pass(xs);
  for (const size_t cut : {size_t(0), size_t(1), size_t(2500), size_t(4999), size_t(5000)}) {
    Moments a = running(xs, 0, cut);
    a.merge(running(xs, cut, xs.size()));
    EXPECT_EQ(a.count(), xs.size());
    EXPECT_NEAR(a.mean(), double(expected.mean), 1e-13);
    EXPECT_NEAR(a.variance(), double(expected.variance), 1e-13) << "cut at " << cut;
  }
  Moments tree;  // many small parts of different sizes
  for (size_t begin = 0, size = 1; begin < xs.size(); begin += size, size = size % 37 + 1) {
    tree.merge(running(xs, begin, std::min(begin + size, xs.size())));
  }
  EXPECT_EQ(tree.count(), xs.size());
  EXPECT_NEAR(tree.variance(), double(expected.variance), 1e-12);
}

TEST(Moments, FewSamples) {
  Moments m;
  EXPECT_EQ(m.count(), 0u);
  EXPECT_EQ(m.mean(), 0.0);
  EXPECT_EQ(m.variance(), 0.0);
  EXPECT_EQ(m.standard_error(), 0.0);
  m.merge(Moments());
  EXPECT_EQ(m.count(), 0u);
  m.add(5.0);
  EXPECT_EQ(m.mean(), 5.0);
  EXPECT_EQ(m.variance(), 0.0);
  m.add(7.0);
  EXPECT_EQ(m.mean(), 6.0);
  EXPECT_EQ(m.variance(), 2.0);
  EXPECT_EQ(m.standard_error(), 1.0);
}

TEST(Moments, ConstantsHaveNoVariance) {
  Moments m;
  for (int i = 0; i < 1000000; ++i) m.add(0.1);
  EXPECT_DOUBLE_EQ(m.mean(), 0.1);
  EXPECT_EQ(m.variance(), 0.0);
}

}  // namespace
}  // namespace emberline
