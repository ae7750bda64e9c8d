// Compares key frames with the formulas of glTF 2.0, appendix C, which are implemented again here.
#include "renderer/description/animation.h"
#include "support/processor_time.h"

#include <gtest/gtest.h>

#include <cmath>

namespace emberline {
namespace {

using Values = std::vector<float>;

KeyFrames keys(Interpolation interpolation, size_t width, const Values& times, const Values& values,
               bool rotations = false) {
  return {interpolation, rotations, width, std::make_shared<const Values>(times),
          std::make_shared<const Values>(values)};
}

std::vector<double> at(const KeyFrames& frames, double time) {
  std::vector<double> value(frames.width);
  sample_keys(frames, time, value);
  return value;
}

// "Spherical Linear Interpolation", as in the appendix.
Quaternion appendix_slerp(const Quaternion& v0, const Quaternion& v1, double t) {
  double d = 0;
  for (size_t i = 0; i < 4; ++i) d += v0[i] * v1[i];
  const double a = std::acos(std::abs(d)), s = d / std::abs(d);
  Quaternion v;
  for (size_t i = 0; i < 4; ++i) {
    v[i] = std::sin(a * (1 - t)) / std::sin(a) * v0[i] + s * std::sin(a * t) / std::sin(a) * v1[i];
  }
  return v;
}

Quaternion turn(double angle, double x, double y, double z) {
  const double s = std::sin(angle / 2) / std::sqrt(x * x + y * y + z * z);
  return {x * s, y * s, z * s, std::cos(angle / 2)};
}

void expect_near(const auto& a, const auto& b, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance) << i;
}

TEST(Animation, StepsHoldUntilTheNextKey) {
  const KeyFrames frames = keys(Interpolation::kStep, 2, {1, 2, 4}, {1, 10, 2, 20, 3, 30});
  const double nearly_two = std::nextafter(2.0f, 0.0f);
  for (const auto& [time, value] : std::vector<std::pair<double, double>>{
           {-5, 1}, {1, 1}, {nearly_two, 1}, {2, 2}, {3.9, 2}, {4, 3}, {1e9, 3}}) {
    EXPECT_EQ(at(frames, time), (std::vector<double>{value, 10 * value})) << time;
  }
}

// Key times are floats, but frame times are doubles. A frame at the time of a key must get its
// value.
TEST(Animation, AFrameAtAKeyIsThere) {
  Values times, values;
  for (int frame = 0; frame <= 1000; ++frame) {
    times.push_back(float(frame) / 24), values.push_back(float(frame));
  }
  const KeyFrames steps = keys(Interpolation::kStep, 1, times, values);
  const KeyFrames lines = keys(Interpolation::kLinear, 1, times, values);
  for (int frame = 0; frame <= 1000; ++frame) {
    EXPECT_EQ(at(steps, frame / 24.0)[0], frame);
    EXPECT_NEAR(at(lines, frame / 24.0)[0], frame, 1e-3);
    EXPECT_EQ(at(steps, (frame + 0.999) / 24.0)[0], frame);
  }
}

TEST(Animation, LinesBetweenKeysAndHeldOutside) {
  const KeyFrames frames =
      keys(Interpolation::kLinear, 3, {0.5f, 1.5f, 1.75f}, {1, 2, 3, 5, -2, 3, 0, 0, 0});
  EXPECT_EQ(at(frames, 0), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(at(frames, 0.5), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(at(frames, 1.5), (std::vector<double>{5, -2, 3}));
  EXPECT_EQ(at(frames, 9), (std::vector<double>{0, 0, 0}));
  for (const double t : {0.1, 0.5, 0.9}) {
    expect_near(at(frames, 0.5 + t),
                std::vector<double>{(1 - t) * 1 + t * 5, (1 - t) * 2 + t * -2, 3}, 1e-15);
  }
  expect_near(at(frames, 1.625), std::vector<double>{2.5, -1, 1.5}, 1e-15);
}

TEST(Animation, CubicSplinesAreTheAppendixs) {
  // The values of each key are its in-tangent, its value and its out-tangent.
  const KeyFrames frames = keys(Interpolation::kCubicSpline, 2, {1, 3, 3.5f},
                                {9, 9, 1, 2, 3, -4, -1, 5, 7, -8, 2, 6, 0.5f, 4, 0, 1, 9, 9});
  const double v0[] = {1, 2}, b0[] = {3, -4}, a1[] = {-1, 5}, v1[] = {7, -8};
  for (const double t : {0.0, 0.2, 0.5, 0.99, 1.0}) {
    std::vector<double> expected;
    const double td = 2;
    for (int c = 0; c < 2; ++c) {
      expected.push_back((2 * t * t * t - 3 * t * t + 1) * v0[c] +
                         td * (t * t * t - 2 * t * t + t) * b0[c] +
                         (-2 * t * t * t + 3 * t * t) * v1[c] + td * (t * t * t - t * t) * a1[c]);
    }
    expect_near(at(frames, 1 + td * t), expected, 1e-14);
  }
  EXPECT_EQ(at(frames, 0), (std::vector<double>{1, 2}));
  EXPECT_EQ(at(frames, 3), (std::vector<double>{7, -8}));
  EXPECT_EQ(at(frames, 4), (std::vector<double>{0, 1}));
}

TEST(Animation, OneKeyIsHeldByEveryInterpolation) {
  for (const double time : {-1.0, 2.0, 5.0}) {
    EXPECT_EQ(at(keys(Interpolation::kStep, 1, {2}, {7}), time)[0], 7);
    EXPECT_EQ(at(keys(Interpolation::kLinear, 1, {2}, {7}), time)[0], 7);
    EXPECT_EQ(at(keys(Interpolation::kCubicSpline, 1, {2}, {5, 7, 9}), time)[0], 7);
  }
}

TEST(Animation, SlerpMatchesTheSpecificationAndTakesTheShorterWay) {
  const Quaternion a = turn(0.3, 1, 2, 3);
  for (const double angle : {0.1, 1.0, 2.5, 3.1}) {
    const Quaternion b = turn(0.3 + angle, 1, 2, 3);
    const Quaternion minus_b = {-b[0], -b[1], -b[2], -b[3]};
    for (const double t : {0.0, 0.25, 0.5, 0.8, 1.0}) {
      expect_near(slerp(a, b, t), appendix_slerp(a, b, t), 1e-13);
      expect_near(slerp(a, minus_b, t), appendix_slerp(a, minus_b, t), 1e-13);
      expect_near(slerp(a, minus_b, t), turn(0.3 + angle * t, 1, 2, 3), 1e-13);
    }
  }
}

TEST(Animation, SlerpOfNearlyEqualRotationsLosesNothing) {
  for (const double angle : {1e-3, 1e-6, 1e-9, 1e-12, 0.0}) {
    const Quaternion a = turn(0, 0, 0, 1), b = turn(angle, 0, 0, 1);
    for (const double t : {0.0, 0.3, 1.0}) {
      const Quaternion q = slerp(a, b, t);
      EXPECT_NEAR(q[2], std::sin(t * angle / 2), 1e-12 * angle) << angle;
      EXPECT_NEAR(q[3], 1, angle * angle + 1e-15);
    }
  }
}

TEST(Animation, RotationsNeedNotHaveUnitLength) {
  const Quaternion a = turn(0.2, 0, 1, 0), b = turn(1.4, 0, 1, 0);
  Quaternion longer = a, shorter = b;
  for (double& c : longer) c *= 300;
  for (double& c : shorter) c *= 1e-20;
  expect_near(slerp(longer, shorter, 0.25), turn(0.5, 0, 1, 0), 1e-15);
}

TEST(Animation, RotationsBetweenKeysHaveUnitLength) {
  const KeyFrames linear = keys(Interpolation::kLinear, 4, {0, 1}, {0, 0, 0, 1, 0, 0, 1, 0}, true);
  expect_near(at(linear, 1.0 / 3), turn(3.14159265358979323846 / 3, 0, 0, 1), 1e-15);
  // The tangents take the spline far away from the unit sphere.
  const Values spline = {0, 0, 0, 0, 0, 0, 0, 1, 3, 0, 0, 0,  //
                         0, 4, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
  const KeyFrames frames = keys(Interpolation::kCubicSpline, 4, {0, 1}, spline, true);
  const KeyFrames plain = keys(Interpolation::kCubicSpline, 4, {0, 1}, spline);
  for (const double t : {0.1, 0.5, 0.7}) {
    std::vector<double> expected = at(plain, t);
    double length = 0;
    for (const double c : expected) length += c * c;
    EXPECT_GT(std::abs(length - 1), 0.001);
    for (double& c : expected) c /= std::sqrt(length);
    expect_near(at(frames, t), expected, 1e-15);
  }
}

TEST(Animation, ASplineThroughNothingKeepsARotation) {
  const KeyFrames frames =
      keys(Interpolation::kCubicSpline, 4, {0, 1},
           {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0}, true);
  EXPECT_EQ(at(frames, 0.5), (std::vector<double>{0, 0, 0, -1}));
}

TEST(Animation, AMillionKeysAreSearchedInHalves) {
  constexpr size_t kCount = 1000000;
  Values times(kCount), values(kCount);
  for (size_t i = 0; i < kCount; ++i) times[i] = float(i), values[i] = float(i % 1000);
  const KeyFrames frames = keys(Interpolation::kLinear, 1, times, values);
  const double start = test::processor_seconds();
  for (size_t i = 0; i + 1 < kCount; i += 3) {
    const double expected = 0.5 * (double(i % 1000) + double((i + 1) % 1000));
    ASSERT_EQ(at(frames, double(i) + 0.5)[0], expected);
  }
  // A linear search would take minutes.
  EXPECT_LT(test::processor_seconds() - start, 20);
}

}  // namespace
}  // namespace emberline
