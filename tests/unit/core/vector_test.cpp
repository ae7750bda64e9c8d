// Tests shading frames, normalisation and the small vector helpers.
#include "renderer/core/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/core/frame.h"
#include "renderer/core/hash.h"
#include "renderer/core/rect.h"

namespace emberline {
namespace {

Vec3f random_unit(uint32_t i) {
  const double z = 2.0 * to_unit_float(hash32(2 * i)) - 1.0;
  const double phi = 6.283185307179586 * to_unit_float(hash32(2 * i + 1));
  const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)};
}

void expect_orthonormal(const Vec3f& n) {
  const ShadingFrame f = ShadingFrame::from_normal(n);
  // The paper states an error of about 1e-6 for float. The length of n is 1 to within 1e-7.
  constexpr float kTolerance = 1.5e-6f;
  ASSERT_EQ(f.normal, n);
  ASSERT_NEAR(dot(f.tangent, f.tangent), 1.0f, kTolerance) << n;
  ASSERT_NEAR(dot(f.bitangent, f.bitangent), 1.0f, kTolerance) << n;
  ASSERT_NEAR(dot(f.tangent, f.bitangent), 0.0f, kTolerance) << n;
  ASSERT_NEAR(dot(f.tangent, n), 0.0f, kTolerance) << n;
  ASSERT_NEAR(dot(f.bitangent, n), 0.0f, kTolerance) << n;
  const Vec3f handed = cross(f.tangent, f.bitangent) - n;  // right-handed
  ASSERT_LT(max_abs_component(handed), kTolerance) << n;
}

TEST(ShadingFrame, OrthonormalForAMillionNormals) {
  for (uint32_t i = 0; i < 1000000; ++i) expect_orthonormal(random_unit(i));
}

// Tries the axes, both signs of zero, normals close to +Z and -Z, and normals with z close to 0,
// where the formula changes its sign.
TEST(ShadingFrame, OrthonormalAtTheHardPlaces) {
  for (const float one : {1.0f, -1.0f}) {
    for (const float zero : {0.0f, -0.0f}) {
      expect_orthonormal({one, zero, zero});
      expect_orthonormal({zero, one, zero});
      expect_orthonormal({zero, zero, one});
    }
  }
  for (double angle = 1.0; angle > 1e-30; angle *= 0.5) {
    for (const double phi : {0.0, 0.7, 2.0, 4.0}) {
      const double s = std::sin(angle);
      const Vec3f n(float(s * std::cos(phi)), float(s * std::sin(phi)), float(std::cos(angle)));
      expect_orthonormal(n);
      expect_orthonormal({n.x, n.y, -n.z});
      expect_orthonormal({n.x, n.z, -n.y});
    }
  }
}

TEST(ShadingFrame, LocalAndWorldAreInverse) {
  for (uint32_t i = 0; i < 10000; ++i) {
    const ShadingFrame f = ShadingFrame::from_normal(random_unit(i));
    const Vec3f v = random_unit(i + 50000);
    EXPECT_LT(max_abs_component(f.to_world(f.to_local(v)) - v), 2e-6f);
    EXPECT_NEAR(f.to_local(v).z, dot(v, f.normal), 0.0f);
  }
  const ShadingFrame up = ShadingFrame::from_normal({0, 0, 1});
  EXPECT_EQ(up.to_local({0.1f, 0.2f, 0.3f}), Vec3f(0.1f, 0.2f, 0.3f));
}

// A vector keeps its direction even if its squared length, such as 1e-58 or 1e60, is outside
// float's range.
TEST(NormalizeOr, AnyLengthThatHasADirection) {
  const Vec3f fallback(0, 0, 1);
  for (uint32_t i = 0; i < 10000; ++i) {
    const Vec3f unit = random_unit(i);
    for (const float length : {1e-29f, 1e-20f, 1e-6f, 1.0f, 1e6f, 1e20f, 1e30f, 1e38f}) {
      const Vec3f n = normalize_or(unit * length, fallback);
      ASSERT_LT(max_abs_component(n - unit), 4e-7f) << unit << " of length " << length;
      ASSERT_NEAR(dot(n, n), 1.0f, 4e-7f);
    }
  }
  EXPECT_EQ(normalize_or({0, 2e-30f, 0}, fallback), Vec3f(0, 1, 0));
  EXPECT_EQ(normalize_or({3e38f, 0, 0}, fallback), Vec3f(1, 0, 0));
}

TEST(NormalizeOr, FallsBackForZeroVectors) {
  const Vec3f fallback(0, 0, 1);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(normalize_or({0, 0, 0}, fallback), fallback);
  EXPECT_EQ(normalize_or({0, -0.0f, 0}, fallback), fallback);
  EXPECT_EQ(normalize_or({1e-31f, 0, 0}, fallback), fallback);
  EXPECT_EQ(normalize_or({kNaN, 1, 0}, fallback), fallback);
  EXPECT_EQ(normalize_or({kInf, 1, 0}, fallback), fallback);
  EXPECT_EQ(normalize_or({-kInf, kInf, 0}, fallback), fallback);
}

TEST(VectorHelpers, ComponentsAndFiniteness) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(max_component({-3, -1, -2}), -1);
  EXPECT_EQ(max_abs_component(Vec3f(-3, 1, 2)), 3);
  EXPECT_EQ(max_abs_component(Vec3d(1, -3, 2)), 3);
  EXPECT_TRUE(is_finite(Vec3f(1, 2, 3)));
  for (const float bad : {kNaN, kInf, -kInf}) {
    EXPECT_FALSE(is_finite(Vec3f(bad, 0, 0)));
    EXPECT_FALSE(is_finite(Vec3f(0, bad, 0)));
    EXPECT_FALSE(is_finite(Vec3f(0, 0, bad)));
  }
  EXPECT_TRUE(is_black(Rgb(0, -0.0f, 0)));
  EXPECT_FALSE(is_black(Rgb(0, 0, 1e-40f)));
  EXPECT_FLOAT_EQ(luminance(Rgb(1, 1, 1)), 1.0f);
  EXPECT_EQ(lerp(2.0f, 4.0f, 0.25f), 2.5f);
  EXPECT_EQ(safe_sqrt(-1e-9f), 0.0f);
  EXPECT_EQ(safe_sqrt(4.0f), 2.0f);
}

TEST(Rect, HalfOpen) {
  const Rect r{2, 3, 5, 7};
  EXPECT_EQ(r.width(), 3);
  EXPECT_EQ(r.height(), 4);
  EXPECT_EQ(r.area(), 12);
  EXPECT_TRUE(r.contains(2, 3));
  EXPECT_TRUE(r.contains(4, 6));
  EXPECT_FALSE(r.contains(5, 6));
  EXPECT_FALSE(r.contains(4, 7));
  EXPECT_FALSE(r.contains(1, 3));
  EXPECT_EQ(r.intersect({0, 0, 4, 4}), (Rect{2, 3, 4, 4}));
  const Rect apart = r.intersect({5, 0, 9, 9});  // the two rectangles touch without overlapping
  EXPECT_TRUE(apart.empty());
  EXPECT_EQ(apart.area(), 0);
  EXPECT_TRUE((Rect{7, 7, 3, 9}).empty());
  EXPECT_EQ((Rect{7, 7, 3, 9}).area(), 0);
  EXPECT_EQ((Rect{0, 0, 100000, 100000}).area(), 10000000000);  // past 2^31
}

}  // namespace
}  // namespace emberline
