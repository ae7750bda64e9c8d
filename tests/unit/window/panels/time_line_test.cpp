#include "renderer/window/panels/time_line.h"

#include <gtest/gtest.h>

namespace emberline {
namespace {

std::vector<AnimationDescription> animations() {
  std::vector<AnimationDescription> list(3);
  list[0].name = "walk";
  list[0].duration = 2.0;
  list[1].duration = 3.0;  // without a name
  list[2].name = "walk";
  list[2].duration = 1.0;
  return list;
}

TEST(TimeLine, ResolvesAnEdit) {
  const auto list = animations();
  EXPECT_TRUE(is_unanimated({}));
  EXPECT_EQ(animation_index({}, list), -1);
  EXPECT_EQ(animation_index({.time = 0.0}, list), 0);
  EXPECT_EQ(animation_index({.name = "walk"}, list), 0);
  EXPECT_EQ(animation_index({.name = "2"}, list), 2);
  EXPECT_EQ(animation_index({.name = "all"}, list), -1);
  for (size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(animation_index({.name = animation_name(i, list)}, list), int(i));
  }
  EXPECT_EQ(duration_of({}, list), 2.0);
  EXPECT_EQ(duration_of({.name = "1"}, list), 3.0);
  EXPECT_EQ(duration_of({.name = "all"}, list), 3.0);
  EXPECT_EQ(duration_of({.name = "all"}, {}), 0.0);
}

TEST(TimeLine, StepsFromFrameToFrame) {
  EXPECT_EQ(frame_at(1.0, 24), 24.0);
  EXPECT_EQ(frame_at(0.99, 24), 23.0);
  double time = 0.0;
  for (int frame = 1; frame <= 72; ++frame) {
    time = step_time(time, 1, 24, 10.0);
    EXPECT_EQ(frame_at(time, 24), frame);
  }
  EXPECT_EQ(step_time(0.51, -1, 2, 10.0), 0.0);
  EXPECT_EQ(step_time(0.0, -1, 24, 10.0), 0.0);
  EXPECT_EQ(step_time(9.99, 1, 24, 10.0), 10.0);
  EXPECT_EQ(step_time(0.0, 1, 24, 0.0), 0.0);
}

TEST(TimeLine, PlaysTheFrameThatIsDue) {
  Playback playback;
  EXPECT_FALSE(playback.playing());
  playback.start(0.5, 100.0);
  EXPECT_TRUE(playback.playing());
  EXPECT_EQ(playback.time_at(100.0, 10, 2.0), 0.5);
  EXPECT_EQ(playback.time_at(100.09, 10, 2.0), 0.5);
  EXPECT_EQ(playback.time_at(100.1, 10, 2.0), 0.6);
  // Late calls skip frames.
  EXPECT_EQ(playback.time_at(101.25, 10, 2.0), 1.7);
  EXPECT_EQ(playback.time_at(101.75, 10, 2.0), 0.2);
  EXPECT_EQ(playback.time_at(107.85, 10, 2.0), 0.3);
  EXPECT_TRUE(playback.playing());
  playback.loop = false;
  EXPECT_EQ(playback.time_at(110.0, 10, 2.0), 2.0);
  EXPECT_FALSE(playback.playing());
}

// Looped playback of an animation of zero duration does not divide by the duration and goes on.
TEST(TimeLine, PlaysAnimationsOfZeroDuration) {
  Playback playback;
  playback.start(0.0, 0.0);
  EXPECT_EQ(playback.time_at(5.0, 24, 0.0), 0.0);
  EXPECT_TRUE(playback.playing());
}

}  // namespace
}  // namespace emberline
