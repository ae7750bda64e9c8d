#include "renderer/app/frame_range.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <set>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

using Frames = std::vector<int>;

std::string rejection_message(const RenderOptions& options) {
  try {
    requested_frames(options);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

// Starts with valid options for two frames, changes them with `set`, and returns the error.
template <typename Set>
std::string message_of_settings(const Set& set) {
  RenderOptions options;
  options.frames = {1, 2};
  options.outputs = {"a.#.exr"};
  set(options);
  return rejection_message(options);
}

TEST(FrameRange, ReadsFarmNotation) {
  const struct {
    const char* text;
    Frames frames;
  } rows[] = {
      {"5", {5}},
      {"-5", {-5}},
      {"0", {0}},
      {"+5", {5}},
      {"1-4", {1, 2, 3, 4}},
      {"1-10x3", {1, 4, 7, 10}},
      {"1-9x3", {1, 4, 7}},
      {"4-1", {4, 3, 2, 1}},
      {"10-1x4", {10, 6, 2}},
      {"-2-2", {-2, -1, 0, 1, 2}},
      {"-3--1", {-3, -2, -1}},
      {"-1--3", {-1, -2, -3}},
      {"7-7", {7}},
      {"7-7x5", {7}},
      {"1-3,20,30-40x5", {1, 2, 3, 20, 30, 35, 40}},
      {"1-3, 20", {1, 2, 3, 20}},
      {"5,1-6,5", {5, 1, 2, 3, 4, 6}},
      {"0001-0003", {1, 2, 3}},
      {"999999999,-999999999", {999999999, -999999999}},
      {"1-999999999x999999998", {1, 999999999}},
  };
  for (const auto& row : rows) EXPECT_EQ(parse_frames(row.text), row.frames) << row.text;
}

TEST(FrameRange, RejectsInvalidRanges) {
  for (const char* text : {"",
                           ",",
                           "1,",
                           ",1",
                           "1,,2",
                           "-",
                           "--",
                           "a",
                           "1-",
                           "1--",
                           "-1-",
                           "1-2-3",
                           "1x2",
                           "1-10x",
                           "1-10x0",
                           "1-10x-1",
                           "1-10x2x3",
                           "1-10y2",
                           "1-10:2",
                           "1..10",
                           "1.5",
                           "1e3",
                           "0x10",
                           "1 2",
                           "1 -2",
                           "nan",
                           "1000000000",
                           "-1000000000",
                           "99999999999999999999",
                           "#",
                           "1-#"}) {
    try {
      parse_frames(text);
      ADD_FAILURE() << text;
    } catch (const UsageError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("--frames: '")) << error.what();
    }
  }
}

TEST(FrameRange, HasAtMostAMillionFrames) {
  EXPECT_EQ(parse_frames("1-1000000").size(), kMaxFrames);
  EXPECT_EQ(parse_frames("-999999999-999999999x2000").size(), 1'000'000u);
  std::string repeated = "1-1000000";  // rejected at once, although the list is long
  for (int i = 0; i < 10'000; ++i) repeated += ",1-1000000";
  for (const std::string& text : {std::string("1-1000001"), std::string("1-1000000,-1"),
                                  std::string("-999999999-999999999"), repeated}) {
    try {
      parse_frames(text);
      ADD_FAILURE() << text;
    } catch (const UsageError& error) {
      EXPECT_NE(std::string(error.what()).find("more than 1000000 frames"), std::string::npos);
      EXPECT_LT(std::string(error.what()).size(), 200u);
    }
  }
}

TEST(FrameRange, ATextGivesTheSameFrames) {
  EXPECT_EQ(format_frames({}), "");
  EXPECT_EQ(format_frames(Frames{7}), "7");
  EXPECT_EQ(format_frames(Frames{7, 8}), "7-8");
  EXPECT_EQ(format_frames(Frames{7, 9}), "7,9");
  EXPECT_EQ(format_frames(Frames{-3, -2, -1}), "-3--1");
  EXPECT_EQ(format_frames(Frames{1, 2, 3, 7, 9, 11, 20}), "1-3,7-11x2,20");
  EXPECT_EQ(format_frames(Frames{9, 6, 3}), "9-3x3");
  std::mt19937 random(1);
  for (int round = 0; round < 1000; ++round) {
    Frames frames;
    std::set<int> taken;
    for (int i = 0; i < 12; ++i) {
      const int frame = int(random() % 24) - 12;
      if (taken.insert(frame).second) frames.push_back(frame);
    }
    EXPECT_EQ(parse_frames(format_frames(frames)), frames) << format_frames(frames);
  }
  Frames all(kMaxFrames);
  std::iota(all.begin(), all.end(), 1);
  EXPECT_EQ(format_frames(all), "1-1000000");
}

// The text field of a render farm may hold anything. Any text gives frames or a one-line error.
TEST(FrameRange, AnyTextIsFramesOrRefused) {
  std::mt19937 random(2);
  constexpr std::string_view kLetters = "0123456789-,x #";
  for (int round = 0; round < 5'000; ++round) {
    std::string text;  // at most five digits
    for (size_t i = random() % 8; i > 0; --i) text += kLetters[random() % kLetters.size()];
    try {
      const Frames frames = parse_frames(text);
      EXPECT_FALSE(frames.empty()) << text;
      EXPECT_EQ(parse_frames(format_frames(frames)), frames) << text;
    } catch (const UsageError&) {
    }
  }
}

TEST(FrameRange, NumbersNames) {
  EXPECT_EQ(expand_frame_number("shot.####.exr", 7), "shot.0007.exr");
  EXPECT_EQ(expand_frame_number("shot.#.exr", 7), "shot.7.exr");
  EXPECT_EQ(expand_frame_number("shot.####.exr", 12345), "shot.12345.exr");
  EXPECT_EQ(expand_frame_number("shot.####.exr", -7), "shot.-007.exr");
  EXPECT_EQ(expand_frame_number("####/a.##.exr", 3), "0003/a.03.exr");
  EXPECT_EQ(expand_frame_number("#", 0), "0");
  EXPECT_EQ(expand_frame_number("shot.exr", 7), "shot.exr");
  EXPECT_EQ(expand_frame_number("", 7), "");
  EXPECT_TRUE(has_frame_number("a#"));
  EXPECT_FALSE(has_frame_number("a"));
}

TEST(FrameRange, EachFrameHasItsOwnNames) {
  RenderOptions options;
  options.frames = {3, 4};
  options.outputs = {"a.##.exr", "b.##.png"};
  options.heatmaps = {"h.#.png"};
  options.reports = {"r.#.json"};
  options.trees = {"t.#.json"};
  options.checkpoint = "c.#";
  options.snapshots = "shots.#";
  options.reference = "ref.####.exr";
  options.save_settings = "take#2.json";
  options.progress_file = "p#.json";
  EXPECT_EQ(requested_frames(options), (Frames{3, 4}));
  options.command_line = "emberline render --frames 3-4";
  const RenderOptions own = options_of_frame(options, 4);
  EXPECT_EQ(own.command_line, "emberline render --frames 3-4 --frames 4") << "repeats this frame";
  EXPECT_EQ(own.outputs, (std::vector<std::string>{"a.04.exr", "b.04.png"}));
  EXPECT_EQ(own.heatmaps.front(), "h.4.png");
  EXPECT_EQ(own.reports.front(), "r.4.json");
  EXPECT_EQ(own.trees.front(), "t.4.json");
  EXPECT_EQ(own.checkpoint, "c.4");
  EXPECT_EQ(own.snapshots, "shots.4");
  EXPECT_EQ(own.reference, "ref.0004.exr");
  EXPECT_EQ(own.frame, 4.0);
  EXPECT_TRUE(own.frames.empty());
  // These two files belong to the whole range, so a # in their names is not replaced.
  EXPECT_EQ(own.save_settings, "take#2.json");
  EXPECT_EQ(own.progress_file, "p#.json");
}

TEST(FrameRange, AnOutputForAllFramesIsRefused) {
  EXPECT_EQ(message_of_settings([](RenderOptions& o) { o.outputs = {"shots/a.b.exr"}; }),
            "-o shots/a.b.exr: every frame of --frames would be written to this file; put #### "
            "where the frame number goes: shots/a.b.####.exr");
  EXPECT_TRUE(message_of_settings([](RenderOptions& o) {
                o.reports = {"r.json"};
              }).starts_with("--report r.json"));
  EXPECT_TRUE(
      message_of_settings([](RenderOptions& o) { o.heatmaps = {"h"}; }).ends_with("goes: h.####"));
  EXPECT_TRUE(
      message_of_settings([](RenderOptions& o) { o.trees = {"t.json"}; }).starts_with("--tree"));
  EXPECT_TRUE(message_of_settings([](RenderOptions& o) {
                o.checkpoint = "c";
              }).starts_with("--checkpoint"));
  EXPECT_TRUE(
      message_of_settings([](RenderOptions& o) { o.snapshots = "s"; }).starts_with("--snapshots"));
  EXPECT_EQ(message_of_settings([](RenderOptions& o) { o.range_report = "r.json"; }), "");
  // Two patterns may give the same name to different frames.
  EXPECT_EQ(message_of_settings([](RenderOptions& o) {
              o.frames = {2, 12};
              o.outputs = {"a.#.exr", "a.1#.exr"};
            }),
            "-o a.#.exr: for frame 12 this is a.12.exr, which is already an output");
}

TEST(FrameRange, TurntableDefinesItsOwnRange) {
  RenderOptions options;
  options.outputs = {"a.##.exr"};
  options.turntable = Turntable{std::nullopt, 3};
  EXPECT_EQ(requested_frames(options), (Frames{1, 2, 3}));
  RenderOptions own = options_of_frame(options, 2);
  EXPECT_EQ(own.turntable, (Turntable{2, 3}));
  EXPECT_FALSE(own.frame) << "the scene stands still";
  options.animation = "all";
  EXPECT_EQ(options_of_frame(options, 2).frame, 2.0);
  options.frames = {7};
  EXPECT_EQ(requested_frames(options), (Frames{7}));
  // A turntable for which one frame is chosen renders that frame alone.
  options = {};
  options.turntable = Turntable{2, 3};
  EXPECT_TRUE(requested_frames(options).empty());
}

}  // namespace
}  // namespace emberline
