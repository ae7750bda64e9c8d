// Every frame of an animation has a seed of its own.
#include <gtest/gtest.h>

#include <optional>
#include <set>

#include "renderer/core/hash.h"
#include "renderer/engine/render_plan.h"

namespace emberline {
namespace {

FrameSettings at_frame(double frame, uint32_t seed = 0) {
  FrameSettings settings;
  settings.frame = frame;
  settings.seed = seed;
  return settings;
}

FrameSettings turned(std::optional<int> frame) {
  FrameSettings settings;
  settings.turntable = Turntable{.frame = frame, .count = 100};
  return settings;
}

TEST(SamplingSeed, IsTheSeedWithoutAFrame) {
  for (const uint32_t seed : {0u, 1u, 4294967295u}) {
    FrameSettings settings;
    settings.seed = seed;
    EXPECT_EQ(sampling_seed(settings), seed);
    settings.time = 1.5;
    EXPECT_EQ(sampling_seed(settings), seed);
    EXPECT_EQ(sampling_seed(at_frame(0, seed)), seed);
    EXPECT_EQ(sampling_seed(at_frame(0.75, seed)), seed);
    settings = at_frame(7, seed);
    settings.static_noise = true;
    EXPECT_EQ(sampling_seed(settings), seed);
  }
}

TEST(SamplingSeed, FramesAreRoundedDown) {
  EXPECT_EQ(frame_number(at_frame(7.9)), 7);
  EXPECT_EQ(frame_number(at_frame(-0.5)), -1);
  EXPECT_EQ(sampling_seed(at_frame(7.9)), sampling_seed(at_frame(7)));
  EXPECT_NE(sampling_seed(at_frame(-0.5)), sampling_seed(at_frame(0)));
}

TEST(SamplingSeed, AFrameOfATurntableCountsAlso) {
  EXPECT_EQ(frame_number(turned(5)), 5);
  EXPECT_EQ(frame_number(turned(std::nullopt)), 1);
  EXPECT_EQ(sampling_seed(turned(5)), sampling_seed(at_frame(5)));
  // In a range, both numbers are those of the frame.
  FrameSettings both = turned(5);
  both.frame = 5;
  EXPECT_EQ(sampling_seed(both), sampling_seed(at_frame(5)));
  // The camera may also turn around one frame of an animation.
  both.frame = 8;
  EXPECT_NE(sampling_seed(both), sampling_seed(at_frame(8)));
  both.turntable->frame = 6;
  FrameSettings next = both;
  next.turntable->frame = 7;
  EXPECT_NE(sampling_seed(both), sampling_seed(next));
  next.turntable->frame = 0;
  EXPECT_NE(sampling_seed(next), sampling_seed(at_frame(8)));
}

// 20,202 seeds of 32 bits share one with a probability of 5 %; these do not. Rounds of `unbiased`
// hash their numbers, too.
TEST(SamplingSeed, FramesSeedsAndRoundsDiffer) {
  std::set<uint32_t> seeds;
  size_t count = 0;
  for (uint32_t seed = 0; seed < 2; ++seed) {
    for (int frame = -5000; frame <= 5000; ++frame, ++count) {
      seeds.insert(sampling_seed(at_frame(frame, seed)));
    }
    for (uint32_t round = 1; round <= 100; ++round, ++count) {
      seeds.insert(hash_combine(seed, round));
    }
  }
  EXPECT_EQ(seeds.size(), count);
}

}  // namespace
}  // namespace emberline
