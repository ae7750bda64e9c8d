// Tests `emberline study`: its files, resuming, and refused options. tests/unit tests the
// statistics.
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "cli/study_fixture.h"

namespace emberline::test {
namespace {

TEST_F(Study, RunsEveryDriverAndEstimatorAndWritesAllFiles) {
  const RunResult result = study(study_words(
      "s", {"--estimators",
            "two-stream,two-stream/mse,two-stream/relmse/unbiased,contrast,painter-sloan,"
            "chi-square,kajiya,dammertz"}));
  EXPECT_NE(result.out.find("adaptive/two-stream/mse"), std::string::npos) << result.out;
  const std::vector<Row> list = rows("s");
  ASSERT_EQ(list.size(), 10u * 2 * 3);
  for (const Row& row : list) {
    SCOPED_TRACE(row.at("method") + " seed " + row.at("seed") + " budget " + row.at("budget"));
    EXPECT_EQ(row.at("status"), "done");
    // The adaptive rounds have fixed sizes, so they may leave part of a budget unused.
    EXPECT_GE(std::stod(row.at("mean_samples")), 0.8 * std::stod(row.at("budget")));
    EXPECT_EQ(std::stod(row.at("samples")), 256 * std::stod(row.at("mean_samples")));
    EXPECT_GT(std::stod(row.at("relmse")), 0);
    EXPECT_GT(std::stod(row.at("flip")), 0);
    EXPECT_GT(std::stod(row.at("wall_s")), 0);
    EXPECT_LT(std::abs(std::stod(row.at("signed_bias"))), 0.5);
  }
  const nlohmann::json json = read_json("s/study.json");
  EXPECT_EQ(json["complete"], true);
  EXPECT_EQ(json["settings"]["baseline"], "bucket");
  EXPECT_EQ(json["reference"]["sampler"], "independent") << "another one than what is studied";
  EXPECT_EQ(json["reference"]["samples_per_pixel"], 64 * 16);
  EXPECT_GE(json["neyman_limits"]["mse"].get<double>(), 1.0);
  EXPECT_EQ(json["summary"].size(), 10u);
  EXPECT_NEAR(json["summary"][0]["metrics"]["mse"]["equal_error_speedup"]["samples"][1]["value"],
              1.0, 1e-9);
  for (const nlohmann::json& method : json["methods"]) {
    const std::string exr = method["pictures"]["exr"], png = method["pictures"]["png"],
                      flip = method["pictures"]["flip"];
    const ExrPicture picture = read_exr(path("s/" + exr));
    double samples = 0;
    for (const float n : picture.channels.at("samples")) samples += double(n) / 256;
    EXPECT_NEAR(samples, method["pictures"]["mean_samples"].get<double>(), 1e-6);
    EXPECT_EQ(read_bytes_picture(path("s/" + png)).width, 16);
    EXPECT_EQ(read_bytes_picture(path("s/" + flip)).width, 16);
  }
  EXPECT_EQ(read_bytes_picture(path("s/pictures/reference.png")).width, 16);
  EXPECT_NE(read_text(path("s/study.html")).find("bisection"), std::string::npos);
}

// The study must list estimates for the picture after each round and for the finished frame.
TEST_F(Study, ListsEstimatedAndTrueErrors) {
  study(study_words("s", {"--drivers", "adaptive", "--spp", "4,64", "--size", "48x32",
                          "--reference-spp", "1024"}));
  const nlohmann::json json = read_json("s/study.json");
  EXPECT_EQ(json["runs"].size(), 2u);
  for (const nlohmann::json& run : json["runs"]) {
    const nlohmann::json &claims = run["calibration"], &last = run["checkpoints"].back();
    ASSERT_GE(claims.size(), 2u) << run;
    EXPECT_EQ(claims[0]["mean_samples"], 8) << "the pilot's";
    double samples = 0;
    for (const nlohmann::json& claim : claims) {
      EXPECT_GT(claim["mean_samples"].get<double>(), samples);
      samples = claim["mean_samples"];
      // With so few pixels and samples, the estimate is accurate only to a factor of two.
      const double ratio = claim["estimate"].get<double>() / claim["true_rms"].get<double>();
      EXPECT_GT(ratio, 0.5) << claim;
      EXPECT_LT(ratio, 2) << claim;
    }
    EXPECT_EQ(claims.back()["mean_samples"], last["mean_samples"]);
    EXPECT_EQ(claims.back()["estimate"], last["estimate"]);
    EXPECT_TRUE(run["checkpoints"][0]["estimate"].is_null());
  }
}

// Raw methods must have the same numbers as in a study without denoised methods. Denoised methods
// must also report the cost of the filter.
TEST_F(Study, ComparesDenoisedAndRawPictures) {
  const Words words = {"--drivers", "bucket,adaptive", "--spp",           "16,64",
                       "--size",    "32x32",           "--reference-spp", "256"};
  const RunResult result =
      study(study_words("s", words + Words{"--denoise", "--estimators", "nested"}));
  EXPECT_NE(result.out.find("estimate : truth"), std::string::npos) << result.out;
  study(study_words("raw", words + Words{"--separate", "--estimators", "nested"}));
  const std::vector<Row> all = rows("s"), raw = rows("raw");
  ASSERT_EQ(all.size(), 4u * 2 * 2);
  size_t denoised = 0;
  for (const Row& row : all) {
    SCOPED_TRACE(row.at("method") + " " + row.at("budget"));
    if (row.at("denoised") == "no") {
      EXPECT_EQ(row.at("filter_cpu_s"), "");
      const auto same = std::ranges::find_if(raw, [&](const Row& other) {
        return other.at("method") == row.at("method") && other.at("seed") == row.at("seed") &&
               other.at("budget") == row.at("budget");
      });
      ASSERT_NE(same, raw.end());
      EXPECT_EQ(same->at("mse"), row.at("mse"));
      continue;
    }
    ++denoised;
    EXPECT_GT(std::stod(row.at("filter_cpu_s")), 0);
    EXPECT_GT(std::stod(row.at("cpu_s")), std::stod(row.at("filter_cpu_s")));
    EXPECT_GT(std::stod(row.at("estimate")), 0);
    EXPECT_LE(std::stod(row.at("kept_share")), 1);
    EXPECT_NEAR(std::stod(row.at("mean_samples")) / std::stod(row.at("budget")), 1, 0.1);
  }
  EXPECT_EQ(denoised, 2u * 2 * 2);
  const nlohmann::json json = read_json("s/study.json");
  EXPECT_TRUE(json["summary"][0]["filter"].empty());
  EXPECT_EQ(json["summary"][1]["filter"].size(), 2u);
  EXPECT_TRUE(json["summary"][1]["metrics"]["mse"]["neyman_fraction"][0].is_null());
  EXPECT_NE(read_text(path("s/study.html")).find("Denoising"), std::string::npos);
}

// Equal samples result in equal bits (law 2 in renderer/README.md). Therefore their errors must be
// equal to the last digit.
TEST_F(Study, UniformDriversHaveEqualErrorsAtEqualSamples) {
  study(study_words("s", {"--drivers", "bucket,bisection", "--spp", "1,2,4,8"}));
  const std::vector<Row> list = contents("s");
  ASSERT_EQ(list.size(), 16u);
  for (size_t i = 0; i < 4; ++i) {
    for (const char* column : {"samples", "mse", "relmse", "flip", "signed_bias", "p95_display"}) {
      EXPECT_EQ(list[i].at(column), list[4 + i].at(column)) << column << " at " << i;
    }
  }
}

// A checkpoint may be in the middle of a pass. It must be taken after the part of at most 4096
// samples that exhausts the budget.
TEST_F(Study, CheckpointsAreTakenWhenTheirBudgetIsSpent) {
  study(study_words("s", {"--drivers", "bisection", "--size", "64x64", "--spp", "20,25,50,64",
                          "--seeds", "1", "--reference-spp", "64"}));
  for (const Row& row : rows("s")) {
    const double samples = std::stod(row.at("samples")), budget = std::stod(row.at("budget"));
    EXPECT_GE(samples, budget * 64 * 64);
    EXPECT_LT(samples, budget * 64 * 64 + 4096);
  }
}

// With a given reference, the numbers must match those of `emberline compare`.
TEST_F(Study, UsesAGivenReference) {
  render(render_words({"--spp", "256", "-o", path("ref.exr"), "--seed", "99"}));
  study(study_words("s", {"--reference", path("ref.exr"), "--drivers", "bucket,adaptive"}));
  const nlohmann::json json = read_json("s/study.json");
  EXPECT_TRUE(json["neyman_limits"].is_null());
  EXPECT_EQ(json["reference"]["two_halves"], false);
  for (size_t m = 0; m < 2; ++m) {
    const std::string exr = json["methods"][m]["pictures"]["exr"];
    const nlohmann::json compared =
        nlohmann::json::parse(run({"compare", path("s/" + exr), path("ref.exr"), "--json"}).out);
    const nlohmann::json& last = json["runs"][m]["checkpoints"].back();
    for (const char* key : {"mse", "relmse", "relmse_trimmed", "flip", "signed_bias"}) {
      EXPECT_NEAR(last[key].get<double>(), compared[key].get<double>(),
                  1e-6 * std::abs(compared[key].get<double>()) + 1e-12)
          << key << " of " << exr;
    }
  }
}

TEST_F(Study, BudgetsInSeconds) {
  const std::string seconds =
      std::to_string(0.01 * kSanitizerSlowdown) + "," + std::to_string(0.05 * kSanitizerSlowdown);
  Words words = study_words("s", {"--seconds", seconds, "--seeds", "1", "--reference-spp", "64",
                                  "--samplers", "sobol,blue_noise"});
  const auto spp = std::ranges::find(words, "--spp");
  words.erase(spp, spp + 2);
  study(words);
  for (const Row& row : rows("s")) {
    if (row.at("status") == "failed") continue;
    SCOPED_TRACE(row.at("method") + " at " + row.at("budget"));
    EXPECT_GE(std::stod(row.at("mean_samples")), 1.0);
    // A uniform progressive frame must never be stopped before its budget is spent.
    if (row.at("method") == "bisection/sobol") {
      EXPECT_GE(std::stod(row.at("wall_s")), std::stod(row.at("budget")));
    }
  }
}

TEST_F(Study, SeparateFramesEndWithTheirTime) {
  const double budget = 0.5 * kSanitizerSlowdown;
  Words words = study_words("s", {"--seconds", std::to_string(budget), "--seeds", "1", "--separate",
                                  "--bucket-size", "4", "--reference-spp", "64"});
  const auto spp = std::ranges::find(words, "--spp");
  words.erase(spp, spp + 2);
  study(words);
  const std::vector<Row> list = rows("s");
  ASSERT_EQ(list.size(), 3u);
  for (const Row& row : list) {
    SCOPED_TRACE(row.at("method"));
    EXPECT_EQ(row.at("status"), "done") << row.at("reason");
    EXPECT_GT(std::stod(row.at("mean_samples")), 16);
    // Only roughly, because other tests use the machine at the same time.
    EXPECT_GT(std::stod(row.at("wall_s")), 0.5 * budget);
    EXPECT_LT(std::stod(row.at("wall_s")), 4 * budget);
  }
}

// A planned frame must be the one that the commands plan and render make.
TEST_F(Study, PlansAsTheCommandDoes) {
  study(study_words("s", {"--drivers", "adaptive", "--estimators", "nested/planned", "--spp", "64",
                          "--seeds", "1", "--reference-spp", "64"}));
  const std::vector<Row> list = rows("s");
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].at("planned"), "yes");
  const Words frame = {scene(), "--size", "16x16", "--spp", "64", "--driver", "adaptive"};
  const RunResult plan = run(Words{"plan"} + frame + Words{"-o", path("frame.plan")});
  ASSERT_EQ(plan.exit_code, 0) << plan.describe();
  render(Words{"render"} + frame + Words{"--plan", path("frame.plan"), "-o", path("frame.exr")});
  const ExrPicture rendered = read_exr(path("frame.exr"));
  const ExrPicture studied = read_exr(
      path("s/" + std::string(read_json("s/study.json")["methods"][0]["pictures"]["exr"])));
  for (const char* channel : {"R", "G", "B"}) {
    EXPECT_EQ(rendered.channels.at(channel), studied.channels.at(channel)) << channel;
  }
  double samples = 0;
  for (const float n : studied.channels.at("samples")) samples += n;
  EXPECT_GE(std::stod(list[0].at("samples")), samples + 16 * 256) << "the pilot counts, too";
  EXPECT_LE(std::stod(list[0].at("samples")), samples + 17 * 256);
}

TEST_F(Study, ListsFailedMethods) {
  const RunResult result =
      study(study_words("s", {"--drivers", "bucket,adaptive", "--samplers", "stratified"}));
  EXPECT_NE(result.out.find("failed"), std::string::npos) << result.out;
  size_t failed = 0;
  for (const Row& row : rows("s")) {
    if (row.at("status") != "failed") continue;
    ++failed;
    EXPECT_EQ(row.at("driver"), "adaptive");
    EXPECT_NE(row.at("reason").find("stratified"), std::string::npos);
    EXPECT_EQ(row.at("mse"), "");
  }
  EXPECT_EQ(failed, 2u);
  EXPECT_EQ(read_json("s/study.json")["summary"][1]["failed_runs"], 2);
  expect_failure(study_words("t", {"--drivers", "adaptive", "--samplers", "stratified"}), 2,
                 {"no method can be rendered", "stratified"});
}

// The test kills the study with SIGKILL, so that no signal handler runs.
TEST_F(Study, ResumesToTheSameBitsAfterAKill) {
  const Words more = {"--spp",   "1,4,128", "--size",          "24x16",
                      "--seeds", "4",       "--reference-spp", "128"};
  study(study_words("whole", more));
  {
    Process process(study_words("killed", more), {.folder = folder_.path()});
    ASSERT_TRUE(process.wait_for_error("3 of 12 runs", 30 * kSanitizerSlowdown))
        << process.error_so_far();
    process.send(SIGKILL);
    process.wait();
  }
  EXPECT_FALSE(exists("killed/study.csv"));
  // If the file of a run is damaged, the run must be repeated.
  size_t kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path("killed/runs"))) {
    if (kept++ == 0) write_text(entry.path().string(), "{\"seed\": 0");
  }
  EXPECT_GE(kept, 2u);
  const RunResult result = study(study_words("killed", more));
  EXPECT_EQ(result.err.find("rendering the reference"), std::string::npos) << result.err;
  EXPECT_EQ(("\n" + result.err).find("\n1 of 12 runs"), std::string::npos) << result.err;
  EXPECT_EQ(contents("killed"), contents("whole"));
}

TEST_F(Study, SignalWritesTheFinishedRuns) {
  const Words more = {"--spp", "1,64", "--size", "96x64", "--seeds", "3", "--reference-spp", "8"};
  Process process(study_words("s", more), {.folder = folder_.path()});
  ASSERT_TRUE(process.wait_for_error("2 of 9 runs", 60 * kSanitizerSlowdown))
      << process.error_so_far();
  process.send(SIGINT);
  const RunResult result = process.wait();
  EXPECT_EQ(result.exit_code, 130) << result.describe();
  EXPECT_EQ(read_json("s/study.json")["complete"], false);
  const size_t finished = rows("s").size();
  EXPECT_GE(finished, 4u);
  EXPECT_LT(finished, 18u);
  study(study_words("s", more));
  EXPECT_EQ(rows("s").size(), 18u);
  EXPECT_EQ(read_json("s/study.json")["complete"], true);
}

TEST_F(Study, ReferenceIsKeptAndRenderedAgainIfDamaged) {
  const Words cache = {"--cache", path("cache"), "--drivers", "bucket", "--reference-spp", "64"};
  EXPECT_NE(study(study_words("a", cache)).err.find("rendering the reference"), std::string::npos);
  EXPECT_EQ(study(study_words("b", cache)).err.find("rendering the reference"), std::string::npos);
  EXPECT_EQ(contents("a"), contents("b"));
  // Another frame must get another reference.
  EXPECT_NE(
      study(study_words("c", cache + Words{"--max-depth", "1"})).err.find("rendering the ref"),
      std::string::npos);
  // Damage a byte in the cached pictures, and then a byte in the cached notes.
  for (const char* suffix : {".exr", ".json"}) {
    for (const auto& entry : std::filesystem::directory_iterator(path("cache"))) {
      if (entry.path().extension() != suffix) continue;
      std::string bytes = read_text(entry.path().string());
      bytes[bytes.size() * 3 / 4] = char(bytes[bytes.size() * 3 / 4] ^ 0x15);
      write_text(entry.path().string(), bytes);
    }
    const RunResult again = study(study_words(std::string("d") + suffix, cache));
    EXPECT_NE(again.err.find("rendered again"), std::string::npos) << again.err;
    EXPECT_EQ(contents("a"), contents(std::string("d") + suffix));
  }
}

TEST_F(Study, ErrorsAreReportedBeforeAnythingIsWritten) {
  render(render_words({"--size", "8x8", "-o", path("small.exr")}));
  write("file", "not a folder");
  struct Case {
    Words words;
    int exit_code;
    Words message_parts;
  };
  const Case cases[] = {
      {{"--drivers", ""}, 2, {"--drivers", "valid names are bucket, bisection, adaptive"}},
      {{"--drivers", "bucket,"}, 2, {"--drivers", "valid names are"}},
      {{"--drivers", "bukket"}, 2, {"did you mean 'bucket'"}},
      {{"--drivers", "bucket,bucket"}, 2, {"--drivers", "twice"}},
      {{"--estimators", "kajia"}, 2, {"--estimators", "did you mean 'kajiya'"}},
      {{"--estimators", "two-stream/l2"}, 2, {"--estimators", "display, mse, relmse"}},
      {{"--estimators", "two-stream/mse/x/y"}, 2, {"--estimators", "ESTIMATOR[/ALLOCATION]"}},
      {{"--samplers", "sobel"}, 2, {"--samplers", "did you mean 'sobol'"}},
      {{"--spp", ""}, 2, {"--spp", "1 to 16777216"}},
      {{"--spp", "0"}, 2, {"--spp", "1 to 16777216"}},
      {{"--spp", "1,-2"}, 2, {"--spp", "'-2'"}},
      {{"--spp", "1,nan"}, 2, {"--spp", "'nan'"}},
      {{"--spp", "1.5"}, 2, {"--spp", "whole"}},
      {{"--spp", "4,2"}, 2, {"--spp", "ascend"}},
      {{"--spp", "2,2"}, 2, {"--spp", "ascend"}},
      {{"--seconds", "1"}, 2, {"--seconds", "--spp"}},
      {{"--seeds", "0"}, 2, {"--seeds", "1 to 10000"}},
      {{"--seeds", "nan"}, 2, {"--seeds", "1 to 10000"}},
      {{"--baseline", "adaptive"}, 2, {"--baseline", "bucket, bisection, adaptive/nested"}},
      {{"--reference-spp", "1"}, 2, {"--reference-spp", "2 to"}},
      {{"--reference-spp", "64", "--reference", "small.exr"}, 2, {"--reference"}},
      {{"--integrator", "pth"}, 2, {"valid names are"}},
      {{"--filter", "gauss"}, 2, {"valid names are"}},
      {{"--crop", "0,0,17,16"}, 2, {"--crop", "inside"}},
      {{"--camera", "nope"}, 2, {"--camera", "'main'"}},
      {{"--convergence"}, 2, {"--convergence", "scene"}},
      {{"--reference", path("none.exr")}, 3, {"none.exr"}},
      {{"--reference", path("small.exr")}, 3, {"8 x 8", "16 x 16"}},
      {{"-o", path("file")}, 1, {path("file")}},
      {{"-o", "/proc/study"}, 1, {"/proc/study"}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::PrintToString(c.words));
    expect_failure(study_words("s", c.words), c.exit_code, c.message_parts);
    EXPECT_FALSE(exists("s"));
  }
  expect_failure({"study", path("none.glb"), "-o", path("s")}, 3, {"none.glb"});
  expect_failure({"study", scene()}, 2, {"-o DIR"});
  expect_failure({"study", "-o", path("s")}, 2, {"study SCENE"});
  Words seconds = {"study", scene(), "-o", path("s"), "--seconds", "nan"};
  for (const char* value : {"nan", "0", "-1", "inf", "2,1", "1,", ""}) {
    seconds.back() = value;
    expect_failure(seconds, 2, {"--seconds"});
  }
}

TEST_F(Study, ConvergenceNeedsNoScene) {
  const RunResult result = study({"study", "--convergence", "--samplers", "sobol,independent",
                                  "--seeds", "300", "-o", path("s")});
  EXPECT_NE(result.out.find("tilted edge"), std::string::npos) << result.out;
  const nlohmann::json json = read_json("s/convergence.json");
  ASSERT_EQ(json["curves"].size(), 10u);
  for (const nlohmann::json& curve : json["curves"]) {
    // With 300 pixels, each of the nine variances of a curve has a standard error of 8 to 15 %. The
    // order, which is fitted over a factor of 256 in samples, has a standard error of about 0.04.
    EXPECT_NEAR(curve["order"].get<double>(), curve["expected_order"].get<double>(), 0.2) << curve;
  }
  std::istringstream csv(read_text(path("s/convergence.csv")));
  size_t lines = 0;
  for (std::string line; std::getline(csv, line);) ++lines;
  EXPECT_EQ(lines, 1u + 10 * 9);
}

}  // namespace
}  // namespace emberline::test
