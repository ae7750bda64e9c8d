// Tests of the neighbouring frames: motion_path.h, align.h, accumulate.h, and denoise() with them.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/display_error.h"
#include "renderer/reconstruction/accumulate.h"
#include "renderer/reconstruction/align.h"
#include "renderer/reconstruction/motion_path.h"
#include "unit/synthetic_halves.h"

namespace emberline::test {
namespace {

constexpr int kColumns = 80, kRows = 200;
constexpr size_t kPixels = size_t(kColumns) * size_t(kRows);
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

size_t at(int x, int y) { return size_t(y) * size_t(kColumns) + size_t(x); }

// The layer `velocity` of a whole frame.
struct Motion {
  std::vector<float> right, up;

  Motion(float to_right, float to_up) : right(kPixels, to_right), up(kPixels, to_up) {}
  VelocityRows rows() const { return {kColumns, kRows, 0, right, up}; }
};

TEST(MotionPath, FollowsBothDirections) {
  const Motion motion(2.5f, -1.25f);  // to the right and down
  MotionPath path(kColumns, kRows, 0, kRows);
  path.step_forward(motion.rows());
  EXPECT_EQ(path.x()[at(10, 20)], 12.5f);
  EXPECT_EQ(path.y()[at(10, 20)], 21.25f);
  path.step_forward(motion.rows());
  EXPECT_EQ(path.x()[at(10, 20)], 15.0f);
  EXPECT_TRUE(std::isnan(path.x()[at(kColumns - 2, 20)]));
  EXPECT_TRUE(std::isnan(path.y()[at(10, kRows - 1)]));
  MotionPath back(kColumns, kRows, 40, 50);
  back.step_back(motion.rows(), motion.rows());
  EXPECT_EQ(back.x()[at(10, 2)], 7.5f);
  EXPECT_EQ(back.y()[at(10, 2)], 42 - 1.25f);
}

// The position before is where the motion of that frame leads here.
TEST(MotionPath, AStepBackInvertsTheMotion) {
  Motion motion(0, 0);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {  // a rotation by 3 degrees, about the middle
      constexpr float kAngle = 3 * 3.14159265f / 180;
      const float dx = float(x - kColumns / 2), dy = float(y - kRows / 2);
      motion.right[at(x, y)] = std::cos(kAngle) * dx - std::sin(kAngle) * dy - dx;
      motion.up[at(x, y)] = -(std::sin(kAngle) * dx + std::cos(kAngle) * dy - dy);
    }
  }
  MotionPath path(kColumns, kRows, 0, kRows);
  path.step_back(motion.rows(), motion.rows());
  path.step_forward(motion.rows());
  int known = 0;
  for (size_t i = 0; i < kPixels; ++i) {
    if (std::isnan(path.x()[i])) continue;
    ++known;
    EXPECT_NEAR(path.x()[i], float(i % kColumns), 0.01f);
    EXPECT_NEAR(path.y()[i], float(i / kColumns), 0.01f);
  }
  EXPECT_GT(known, int(0.9 * kPixels));
}

TEST(MotionPath, WhatIsTooFarOrNotANumberIsUnknown) {
  for (const auto& [right, up] :
       {std::pair(0.0f, float(kMotionReach + 1)), std::pair(kNotANumber, 0.0f),
        std::pair(0.0f, std::numeric_limits<float>::infinity()), std::pair(1e30f, -1e30f)}) {
    const Motion motion(right, up);
    MotionPath forward(kColumns, kRows, 0, kRows), back = forward;
    forward.step_forward(motion.rows());
    back.step_back(motion.rows(), motion.rows());
    forward.step_forward(motion.rows());
    for (size_t i = 0; i < kPixels; ++i) {
      ASSERT_TRUE(std::isnan(forward.x()[i]) && std::isnan(forward.y()[i])) << i;
      ASSERT_TRUE(std::isnan(back.x()[i])) << i;
    }
  }
}

// A neighbour in which everything is `right` and `down` pixels away.
struct Shifted {
  std::vector<float> x, y;
  NeighbourFrame frame;

  Shifted(const SyntheticHalves& halves, float right, float down) {
    for (size_t i = 0; i < kPixels; ++i) {
      x.push_back(float(i % kColumns) + right);
      y.push_back(float(i / kColumns) + down);
    }
    frame = {halves.input(), x, y};
  }
};

TEST(AlignedFrame, InterpolatesBetweenPixels) {
  SyntheticHalves halves(kColumns, kRows, 4.0f);
  const auto truth = [](float x, float y) { return 3 + 0.1f * x + 0.001f * x * x - 0.005f * y; };
  halves.set_colour([&](int x, int y) { return truth(float(x), float(y)); }, constant(0.0f));
  halves.add_feature([](int x, int) { return float(x); }, constant(0.0f));
  const Shifted shifted(halves, 0.3f, -1.75f);
  const AlignedFrame aligned(shifted.frame, kColumns, kRows);
  for (int y = 3; y < kRows - 3; ++y) {
    for (int x = 3; x < kColumns - 3; ++x) {
      const float expected = truth(float(x) + 0.3f, float(y) - 1.75f);
      ASSERT_NEAR(aligned.input().colour[1].b[at(x, y)], expected, 1e-4f);
      ASSERT_NEAR(aligned.input().features[0].a[at(x, y)], float(x) + 0.3f, 1e-3f);
      ASSERT_NEAR(aligned.input().samples.a[at(x, y)], 4.0f, 1e-5f);
    }
  }
  EXPECT_NEAR(aligned.input().samples.a[at(kColumns - 1, 20)], 4.0f, 1e-5f);
  EXPECT_EQ(aligned.input().samples.a[at(20, 0)], 0.0f);  // it was above the picture
}

TEST(AlignedFrame, UnknownPixelsHaveNoSamples) {
  SyntheticHalves halves(kColumns, kRows, 4.0f);
  halves.set_colour(constant(1.0f), constant(0.1f));
  halves.counts()[at(30, 30)] = 0.0f;
  halves.colour(0)[at(50, 50)] = kNotANumber;
  Shifted shifted(halves, 0.5f, 0.0f);
  shifted.x[at(5, 5)] = kNotANumber;
  shifted.y[at(6, 5)] = 1e30f;
  const AlignedFrame aligned(shifted.frame, kColumns, kRows);
  const std::span<const float> counts = aligned.input().samples.b;
  for (const size_t i : {at(5, 5), at(6, 5), at(28, 30), at(31, 29)}) EXPECT_EQ(counts[i], 0.0f);
  for (const size_t i : {at(7, 5), at(27, 30), at(32, 30), at(30, 33)})
    EXPECT_NEAR(counts[i], 4.0f, 1e-5f);
  for (const float value : aligned.input().colour[0].a) ASSERT_TRUE(std::isfinite(value));
}

float blobs(int x, int y) {
  return 0.5f + 0.3f * std::sin(0.15f * float(x)) * std::cos(0.1f * float(y));
}

// A frame of a sequence in which nothing moves. Only the noise differs between frames.
SyntheticHalves frame_of_sequence(uint32_t seed, float light = 1.0f, float albedo = 0.8f) {
  SyntheticHalves halves(kColumns, kRows, 8.0f, seed);
  halves.set_colour([=](int x, int y) { return light * blobs(x, y); }, constant(0.4f));
  halves.set_albedo(constant(albedo), constant(0.02f));
  halves.add_feature([](int x, int) { return 0.01f * float(x); }, constant(0.01f));
  return halves;
}

double combined_frames(const SyntheticHalves& own, std::span<const NeighbourFrame> neighbours) {
  DenoiseInput input = own.input();
  input.tolerances = {0.1f};
  const AccumulatedFrames frames(input, prepare_colour(input), neighbours);
  return frames.frames(0, kRows) / double(kPixels);
}

TEST(AccumulatedFrames, CountsWhatTheNeighboursShare) {
  const SyntheticHalves own = frame_of_sequence(1), next = frame_of_sequence(2),
                        last = frame_of_sequence(3);
  const Shifted a(next, 0, 0), b(last, 0, 0);
  const NeighbourFrame both[] = {a.frame, b.frame};
  EXPECT_GT(combined_frames(own, both), 2.2);  // noise makes them look different in part
  EXPECT_LE(combined_frames(own, both), 3.0);
  const SyntheticHalves other_surface = frame_of_sequence(2, 1.0f, 0.5f);
  const Shifted covered(other_surface, 0, 0);
  EXPECT_LT(combined_frames(own, {&covered.frame, 1}), 1.01);
  const SyntheticHalves other_light = frame_of_sequence(2, 3.0f);
  const Shifted lit(other_light, 0, 0);
  EXPECT_LT(combined_frames(own, {&lit.frame, 1}), 1.1);
}

// The weights of a half come from the other half, so the mean is not biased towards neighbours that
// happen to be similar. The tolerance is 4 standard errors.
TEST(AccumulatedFrames, TheMeanIsUnbiasedAndHasLessNoise) {
  const SyntheticHalves own = frame_of_sequence(1), next = frame_of_sequence(2),
                        last = frame_of_sequence(3);
  const Shifted a(next, 0, 0), b(last, 0, 0);
  const NeighbourFrame both[] = {a.frame, b.frame};
  const DenoiseInput input = own.input();
  const AccumulatedFrames frames(input, prepare_colour(input), both);
  double sum = 0, squares = 0, before = 0;
  for (size_t i = 0; i < kPixels; ++i) {
    const double error = double(frames.input().colour[0].a[i]) - double(own.truth()[i]);
    const double raw = double(input.colour[0].a[i]) - double(own.truth()[i]);
    sum += error;
    squares += error * error;
    before += raw * raw;
  }
  const double count = double(kPixels), deviation = std::sqrt(squares / count);
  EXPECT_LT(std::abs(sum / count), 4 * deviation / std::sqrt(count));
  EXPECT_GT(before / squares, 2.6);
}

struct Sequence {
  SyntheticHalves own = frame_of_sequence(1), next = frame_of_sequence(2),
                  last = frame_of_sequence(3);
  Shifted a{next, 0, 0}, b{last, 0, 0};
  std::vector<NeighbourFrame> neighbours = {a.frame, b.frame};
};

TEST(DenoiseAcross, RemovesMoreNoiseAndKnowsWhatIsLeft) {
  const Sequence s;
  const DenoisedPicture alone = denoise(s.own.input());
  const DenoisedPicture across = denoise(s.own.input(), {}, s.neighbours);
  EXPECT_LT(s.own.squared_error(across.colour[0]), s.own.squared_error(alone.colour[0]) / 1.3);
  EXPECT_GT(across.frames / double(kPixels), 2.2);
  EXPECT_EQ(alone.frames, double(kPixels));
  double truth = 0;
  for (size_t i = 0; i < kPixels; ++i) {
    const double d =
        double(display_value(across.colour[0][i])) - double(display_value(s.own.truth()[i]));
    truth += d * d;
  }
  const double ratio = std::sqrt(across.squared_error_after / truth);
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.4);
}

// Neighbours that show something else do no harm.
TEST(DenoiseAcross, OtherFramesAreNotBlendedIn) {
  const SyntheticHalves own = frame_of_sequence(1);
  const double alone = own.squared_error(denoise(own.input()).colour[0]);
  SyntheticHalves noise(kColumns, kRows, 8.0f, 5);
  noise.set_colour([](int x, int y) { return float((x * 7919 + y * 104729) % 97) / 30.0f; },
                   constant(0.4f));
  noise.set_albedo(constant(0.8f), constant(0.02f));
  noise.add_feature([](int x, int) { return 0.01f * float(x); }, constant(0.01f));
  for (const SyntheticHalves& other : {frame_of_sequence(2, 0.2f), frame_of_sequence(2, 5.0f),
                                       frame_of_sequence(2, 1.0f, 0.1f), noise}) {
    const Shifted neighbour(other, 0, 0);
    const DenoisedPicture out = denoise(own.input(), {}, {&neighbour.frame, 1});
    EXPECT_LT(own.squared_error(out.colour[0]), 1.02 * alone);
  }
}

TEST(DenoiseAcross, PartsStillAddUp) {
  Sequence s;
  for (SyntheticHalves* frame : {&s.own, &s.next, &s.last}) {
    for (const float share : {0.25f, 0.6f, 0.15f}) frame->add_part(share);
  }
  s.neighbours = {{s.next.input(), s.a.x, s.a.y}, {s.last.input(), s.b.x, s.b.y}};
  const DenoisedPicture out = denoise(s.own.input(), {}, s.neighbours);
  ASSERT_EQ(out.parts.size(), 3u);
  for (size_t i = 0; i < kPixels; ++i) {
    const float sum = out.parts[0][1][i] + out.parts[1][1][i] + out.parts[2][1][i];
    ASSERT_NEAR(sum, out.colour[1][i], 2e-5f) << i;
    ASSERT_NEAR(out.parts[1][1][i], 0.6f * out.colour[1][i], 1e-4f) << i;
  }
}

TEST(DenoiseAcross, SameBitsForAnyThreadsAndBands) {
  Sequence s;
  for (SyntheticHalves* frame : {&s.own, &s.next, &s.last}) {
    frame->blur_with_neighbours();
    frame->add_part(0.5f);
  }
  const Shifted moved(s.next, 1.3f, -2.6f);
  s.neighbours = {moved.frame, {s.last.input(), s.b.x, s.b.y}};
  const DenoiseInput input = s.own.input();
  DenoisedPicture whole, other;
  tbb::task_arena(1).execute([&] { whole = denoise(input, {}, s.neighbours); });
  tbb::task_arena(2).execute([&] { other = denoise(input, {}, s.neighbours); });
  EXPECT_EQ(whole.colour, other.colour);
  EXPECT_EQ(whole.error, other.error);
  EXPECT_EQ(whole.parts, other.parts);
  double frames = 0;
  for (const auto& [begin, end] :
       {std::pair(0, 5), std::pair(5, 80), std::pair(80, 120), std::pair(120, kRows)}) {
    const DenoisedPicture band = denoise(input, begin, end, {}, s.neighbours);
    const auto equal = [&](const std::vector<float>& a, const std::vector<float>& b) {
      return std::equal(b.begin(), b.end(), a.begin() + std::ptrdiff_t(at(0, begin)));
    };
    EXPECT_TRUE(equal(whole.colour[2], band.colour[2]));
    EXPECT_TRUE(equal(whole.error, band.error));
    EXPECT_TRUE(equal(whole.parts[0][0], band.parts[0][0]));
    frames += band.frames;
  }
  EXPECT_NEAR(frames, whole.frames, 1e-3);
}

TEST(DenoiseAcross, NoNumberOutOfNonNumbers) {
  Sequence s;
  const float bad[] = {kNotANumber, std::numeric_limits<float>::infinity(), -3e38f, 3e38f};
  for (size_t k = 0; k < 4; ++k) {
    s.next.colour(k % 2)[at(20, int(10 * k))] = bad[k];
    s.next.feature(k % 2)[at(30, int(10 * k))] = bad[k];
    s.next.counts()[at(40, int(10 * k))] = bad[k];
  }
  const Shifted next(s.next, 0.4f, 0.4f);
  s.neighbours[0] = next.frame;
  const DenoisedPicture out = denoise(s.own.input(), {}, s.neighbours);
  for (size_t i = 0; i < kPixels; ++i) {
    ASSERT_TRUE(std::isfinite(out.colour[0][i])) << i;
    ASSERT_TRUE(out.error[i] >= 0.0f && out.error[i] <= 0.5f) << i;
  }
  EXPECT_LT(s.own.squared_error(out.colour[0]), s.own.squared_error(s.own.raw()) / 4);
}

}  // namespace
}  // namespace emberline::test
