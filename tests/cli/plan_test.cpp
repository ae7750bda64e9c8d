// Tests `emberline plan` and frames whose sample counts come from a plan.

#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cli/command_test.h"
#include "io/files/record_file.h"
#include "renderer/core/moments.h"

namespace emberline::test {
namespace {

class Plan : public CommandTest {
 protected:
  static Words adaptive() {
    return {"--driver", "adaptive", "--spp", "48", "--size", "40x24", "--bucket-size", "16"};
  }
  Words plan_words(const Words& more = {}) {
    return Words{"plan", scene(), "-o", path("frame.plan")} + adaptive() + more;
  }
  Words planned(const std::string& output, const Words& more = {}) {
    return Words{"render", scene(), "-o", path(output)} + adaptive() +
           Words{"--plan", path("frame.plan")} + more;
  }
  void write_bytes(const std::string& name, const std::vector<uint8_t>& bytes) const {
    write(name, std::string(bytes.begin(), bytes.end()));
  }
};

TEST_F(Plan, WholeFrameEqualsItsPartsCropsAndThreads) {
  for (const Words& more : {Words{}, Words{"--noise-threshold", "0.03", "--denoise"}}) {
    render(plan_words(more));
    render(planned("whole.exr", more + Words{"--threads", "1"}));
    const ExrPicture whole = read_exr(path("whole.exr"));
    render(planned("again.exr", more + Words{"--threads", "3", "--bucket-order", "spiral"}));
    EXPECT_EQ(first_difference(whole, read_exr(path("again.exr"))), "");
    for (const char* part : {"1/2", "2/2"}) {
      render(planned("merged.exr", more + Words{"--part", part}));
    }
    render({"merge", path("merged.exr.part-1-of-2.checkpoint"),
            path("merged.exr.part-2-of-2.checkpoint"), "-o", path("merged.exr")});
    EXPECT_EQ(first_difference(whole, read_exr(path("merged.exr"))), "");
    // The denoised layer of a crop differs, because it lacks the neighbouring pixels.
    render(planned("crop.exr", more + Words{"--crop", "5,3,33,20", "--bucket-size", "7"}));
    const ExrPicture crop = read_exr(path("crop.exr"));
    for (const char* channel : {"R", "G", "B", "A", "samples"}) {
      for (int y = 3; y < 20; ++y) {
        for (int x = 5; x < 33; ++x)
          ASSERT_EQ(crop.at(channel, x, y), whole.at(channel, x, y)) << channel << x << ',' << y;
      }
    }
  }
}

TEST_F(Plan, CountsKeepTheBudgetAndFollowTheNoise) {
  const RunResult made = render(plan_words());
  EXPECT_NE(made.err.find("frame.plan: 4"), std::string::npos) << made.describe();
  render(planned("out.exr"));
  const ExrPicture picture = read_exr(path("out.exr"));
  const std::vector<float>& samples = picture.channels.at("samples");
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / double(samples.size());
  EXPECT_LE(mean, 48.0);
  EXPECT_GT(mean, 44.0);
  const auto [least, most] = std::ranges::minmax(samples);
  EXPECT_GE(least, 8);
  EXPECT_GE(most, 2 * least);
}

// Wires a twentieth of a pixel wide on black. With 16 samples, an adaptive frame loses 6 % of
// their light, because its own samples decide where the others go. The samples of a plan do not.
// The bound is four standard errors, a false alarm for 6e-5 of all choices of seeds; the seeds are
// 0 to 59.
TEST_F(Plan, FramesAreUnbiased) {
  GltfBuilder gltf;
  const int glow = gltf.push("materials", {{"emissiveFactor", {1, 1, 1}}, {"doubleSided", true}});
  for (const float x : {-8.7f, -2.9f, 3.7f, 8.9f}) {
    add_quad(gltf, {x, -9, 0}, {0.05f, 0, 0}, {0.7f, 18, 0}, glow);
  }
  gltf.push("cameras",
            {{"type", "orthographic"},
             {"orthographic", {{"xmag", 12}, {"ymag", 8}, {"znear", 0.1}, {"zfar", 100}}}});
  gltf.add_to_scene(gltf.push("nodes", {{"camera", 0}, {"translation", {0, 0, 10}}}));
  const std::string wires = gltf.write_glb(path("wires.glb"));
  const Words size = {"--size", "24x16", "--max-depth", "1", "--threads", "1"};
  const auto mean = [&](const Words& more) {
    render(Words{"render", wires, "-o", path("wires.exr")} + size + more);
    const std::vector<float> values = read_exr(path("wires.exr")).channels.at("G");
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
  };
  const double exact = mean({"--spp", "16384", "--threads", "2"});
  Moments planned, adaptive;
  for (int seed = 0; seed < 60; ++seed) {
    const Words frame = {"--driver", "adaptive", "--spp", "16", "--seed", std::to_string(seed)};
    adaptive.add(mean(frame) / exact - 1);
    render(Words{"plan", wires, "-o", path("wires.plan")} + size + frame);
    planned.add(mean(frame + Words{"--plan", path("wires.plan")}) / exact - 1);
  }
  EXPECT_NEAR(planned.mean(), 0, 4 * planned.standard_error());
  EXPECT_LT(planned.standard_error(), 0.02);
  EXPECT_LT(adaptive.mean(), -0.03) << "the test can no longer tell the two apart";
  std::printf("  planned %.3f +- %.3f, adaptive %.3f +- %.3f\n", planned.mean(),
              planned.standard_error(), adaptive.mean(), adaptive.standard_error());
}

TEST_F(Plan, StoppedFrameResumes) {
  render(plan_words());
  render(planned("whole.exr"));
  const Words words = planned("out.exr", {"--resume", "--resumable"});
  run(words + Words{"--time-limit", "0.001"});
  render(words);
  EXPECT_EQ(first_difference(read_exr(path("whole.exr")), read_exr(path("out.exr"))), "");
  // The plan's bytes belong to the frame.
  render(plan_words({"--max-spp", "64"}));
  expect_failure(words + Words{"--max-spp", "64"}, 3, {"out.exr.checkpoint", "--plan changed"});
  expect_failure({"extend", path("out.exr"), "--spp", "64"}, 3, {"come from a plan"});
  const RunResult info = run({"info", path("out.exr")});
  EXPECT_NE(info.out.find("cannot be extended: its sample counts come from a plan"),
            std::string::npos)
      << info.describe();
}

TEST_F(Plan, AnotherFrameIsRefused) {
  render(plan_words());
  const std::pair<Words, std::string> rows[] = {{{"--spp", "64"}, "--spp: 48 (now 64)"},
                                                {{"--seed", "1"}, "--seed: 0 (now 1)"},
                                                {{"--max-spp", "64"}, "--max-spp"},
                                                {{"--max-depth", "2"}, "--max-depth"},
                                                {{"--size", "41x24"}, "40x24"}};
  for (const auto& [more, reason] : rows) {
    expect_failure(planned("out.exr", more), 3, {"frame.plan", reason});
  }
  render(plan_words({"--crop", "0,0,20,24"}));
  expect_failure(planned("out.exr", {"--crop", "10,0,21,24"}), 3,
                 {"frame.plan", "0,0,20,24", "10,0,21,24"});
  render(planned("out.exr", {"--crop", "10,0,20,24"}));
  expect_failure(planned("out.exr", {"--crop", "0,0,20,24", "--denoise"}), 3,
                 {"frame.plan", "without --denoise"});
  // Other channels do not affect the samples.
  render(planned("out.exr", {"--crop", "0,0,20,10", "--aov", "albedo,variance", "--light-groups"}));
}

TEST_F(Plan, PartsOfTwoPlansAreNotMerged) {
  render(plan_words());
  render(planned("out.exr", {"--part", "1/2"}));
  // A plan with other counts under the same head.
  std::vector<uint8_t> other = read_bytes(path("frame.plan"));
  render(plan_words({"--noise-threshold", "0.1"}));
  render(planned("out.exr", {"--part", "2/2", "--noise-threshold", "0.1"}));
  expect_failure({"merge", path("out.exr.part-1-of-2.checkpoint"),
                  path("out.exr.part-2-of-2.checkpoint"), "-o", path("out.exr")},
                 3, {"--plan changed"});
}

TEST_F(Plan, DamagedFilesAreRefused) {
  render(plan_words());
  const std::vector<uint8_t> bytes = read_bytes(path("frame.plan"));
  for (size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 40) {
    write_bytes("frame.plan", {bytes.begin(), bytes.begin() + std::ptrdiff_t(length)});
    expect_failure(planned("out.exr"), 3, {"frame.plan"});
  }
  for (size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 40) {
    std::vector<uint8_t> flipped = bytes;
    flipped[at] ^= 0x10;
    write_bytes("frame.plan", flipped);
    expect_failure(planned("out.exr"), 3, {"frame.plan"});
  }
  write("frame.plan", "counts");
  expect_failure(planned("out.exr"), 3, {"frame.plan", "not a plan"});
  std::filesystem::remove(path("frame.plan"));
  expect_failure(planned("out.exr"), 3, {"frame.plan", "not found"});
  render(Words{"render", scene(), "-o", path("a.exr"), "--resumable"} + adaptive());
  std::filesystem::rename(path("a.exr.checkpoint"), path("frame.plan"));
  expect_failure(planned("out.exr"), 3, {"frame.plan", "a checkpoint, not a plan"});
}

// The heads have valid checksums, but the crops are not inside the frame or have no area.
TEST_F(Plan, HostileCropsAreRefused) {
  render(plan_words());
  const nlohmann::json good = nlohmann::json::parse(RecordFile(path("frame.plan")).head());
  for (const char* crop : {"-2147483648,0,2147483647,600", "0,0,1518500250,1518500250",
                           "-1,0,40,24", "0,0,41,24", "0,0,0,0", "40,24,0,0", "x"}) {
    nlohmann::json head = good;
    head["settings"]["crop"] = crop;
    write("frame.plan", pack_file_head(head.dump()) + pack_record(3, 0, {}));
    expect_failure(planned("out.exr"), 3, {"frame.plan"});
  }
  for (const char* size : {"65536x65536", "1x1"}) {
    nlohmann::json head = good;
    head["settings"]["size"] = size;
    write("frame.plan", pack_file_head(head.dump()) + pack_record(3, 0, {}));
    expect_failure(planned("out.exr"), 3, {"frame.plan"});
  }
}

// A plan never has more samples than the budget. The settings file of a farm is for frames: it may
// limit their time, and it names the plan that is only now made.
TEST_F(Plan, SmallBudgetsAndSettingsFiles) {
  write(
      "look.json",
      nlohmann::json{{"time-limit", 0.001}, {"part", "1/2"}, {"plan", path("frame.plan")}}.dump());
  for (const std::string spp : {"1", "4", "16"}) {
    render(plan_words({"--settings", path("look.json"), "--spp", spp}));
    render(planned("out.exr", {"--spp", spp}));
    const std::vector<float> samples = read_exr(path("out.exr")).channels.at("samples");
    const double total = std::accumulate(samples.begin(), samples.end(), 0.0);
    EXPECT_LE(total, std::stod(spp) * double(samples.size()));
    EXPECT_GE(total, 0.9 * std::stod(spp) * double(samples.size()));
  }
}

// A farm's job may be preempted, so the pilot can continue.
TEST_F(Plan, AStoppedPilotContinues) {
  const Words words = Words{"plan",     scene(), "-o",   path("frame.plan"), "--driver",
                            "adaptive", "--spp", "4096", "--size",           "64x64"};
  const Words resuming =
      words + Words{"--resume", "--progress-file", path("plan.json"), "--checkpoint-interval", "1"};
  {
    Process process(resuming + Words{"--verbose"}, {.folder = folder_.path()});
    ASSERT_TRUE(process.wait_until_busy()) << process.error_so_far();
    process.send(SIGTERM);
    const RunResult result = process.wait();
    EXPECT_EQ(result.exit_code, 130) << result.describe();
    EXPECT_NE(result.err.find("frame.plan was not written"), std::string::npos);
  }
  EXPECT_FALSE(std::filesystem::exists(path("frame.plan")));
  ASSERT_TRUE(std::filesystem::exists(path("frame.plan.checkpoint")));
  EXPECT_EQ(read_json("plan.json")["state"], "stopped");
  expect_failure(resuming + Words{"--seed", "1"}, 3, {"frame.plan.checkpoint", "another frame"});
  render(resuming);
  EXPECT_FALSE(std::filesystem::exists(path("frame.plan.checkpoint")));
  EXPECT_EQ(read_json("plan.json")["state"], "done");
  const std::vector<uint8_t> resumed = read_bytes(path("frame.plan"));
  render(words);
  EXPECT_EQ(read_bytes(path("frame.plan")), resumed);
}

TEST_F(Plan, ReplacesOnlyPlans) {
  write("frame.plan", "notes");
  expect_failure(plan_words(), 2, {"frame.plan", "not a plan", "name another file"});
  std::filesystem::remove(path("frame.plan"));
  render(plan_words());
  const std::vector<uint8_t> first = read_bytes(path("frame.plan"));
  render(plan_words({"--threads", "1"}));
  EXPECT_EQ(read_bytes(path("frame.plan")), first);
  expect_failure(plan_words({"--progress-file", path("frame.plan")}), 2,
                 {"--progress-file", "frame.plan"});
  EXPECT_EQ(read_bytes(path("frame.plan")), first);
  // No frame may resume from a plan.
  expect_failure(Words{"render", scene(), "-o", path("out.exr"), "--resume", "--checkpoint",
                       path("frame.plan")} +
                     adaptive(),
                 3, {"frame.plan", "another frame"});
}

TEST_F(Plan, WhatCannotBePlannedIsRefused) {
  const std::pair<Words, Words> rows[] = {{{"--unbiased"}, {"--unbiased"}},
                                          {{"--estimator", "kajiya"}, {"kajiya"}},
                                          {{"--driver", "bucket"}, {"--driver adaptive"}}};
  for (const auto& [more, parts] : rows) {
    expect_failure(plan_words(more), 2, parts);
    expect_failure(planned("out.exr", more), 2, parts);
  }
  expect_failure({"plan", scene()}, 2, {"-o FILE.plan"});
  for (const Words& more :
       {Words{"--sample-range", "0-4"}, Words{"--frames", "1-2", "-o", path("f.####.exr")},
        Words{"--snapshots", path("snapshots")}, Words{"--explain", "1,1"}}) {
    expect_failure(planned("out.exr", more), 2, {more[0]});
  }
  // Without a plan, an adaptive frame has no parts.
  expect_failure(Words{"render", scene(), "-o", path("out.exr"), "--part", "1/2"} + adaptive(), 2,
                 {"--part", "--plan"});
}

}  // namespace
}  // namespace emberline::test
