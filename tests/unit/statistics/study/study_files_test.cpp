// Tests the files of a study: writing and reading them loses nothing.
#include "renderer/statistics/study/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/json/input.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

StudyRun awkward_run() {
  StudyRun run;
  run.seed = 4000000000u;
  StudyCheckpoint& c = run.checkpoints.emplace_back();
  c.budget = 0.1;
  c.samples = (uint64_t(1) << 53) - 1;
  c.mean_samples = 1.0 / 3;
  c.wall_s = 1e-9;
  c.cpu_s = 0.1 + 0.2;
  c.error = {1e-300, 0.1, -1e-7, 5e-324, 0.25, -0.0, std::nan(""), 1.0 / 7};
  c.estimate = 1.0 / 9;
  c.filter = {1.0 / 11, 1.0 / 13};
  run.calibration = {{16, 0.01, std::nan("")}, {32, 0.02, 0.03}};
  run.non_finite_samples = 3;
  return run;
}

// Returns nothing for invalid text, and tells the reason in `*message`.
std::optional<StudyRun> read_back(const std::string& text, std::string_view key,
                                  std::string* message = nullptr) {
  const std::string file = "run.json";
  try {
    const nlohmann::json json = parse_json(text, file);
    return parse_run(JsonReader(json, file), key);
  } catch (const InputError& error) {
    if (message) *message = error.what();
    return std::nullopt;
  }
}

TEST(StudyFiles, ARunComesBackAsItWas) {
  const StudyRun run = awkward_run();
  const std::optional<StudyRun> back = read_back(run_json(run, "the key"), "the key");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->seed, run.seed);
  EXPECT_EQ(back->status, StudyRunStatus::kDone);
  ASSERT_EQ(back->checkpoints.size(), 1u);
  const StudyCheckpoint &a = run.checkpoints[0], &b = back->checkpoints[0];
  EXPECT_EQ(a.budget, b.budget);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.mean_samples, b.mean_samples);
  EXPECT_EQ(a.wall_s, b.wall_s);
  EXPECT_EQ(a.cpu_s, b.cpu_s);
  EXPECT_EQ(a.estimate, b.estimate);
  ASSERT_TRUE(b.filter);
  EXPECT_EQ(a.filter->cpu_s, b.filter->cpu_s);
  EXPECT_EQ(a.filter->unchanged_fraction, b.filter->unchanged_fraction);
  EXPECT_EQ(a.error.signed_bias, b.error.signed_bias);
  for (const StudyMetricEntry& metric : study_metric_table()) {
    const double x = a.error.*metric.value, y = b.error.*metric.value;
    EXPECT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << metric.name;
  }
  ASSERT_EQ(back->calibration.size(), 2u);
  EXPECT_TRUE(std::isnan(back->calibration[0].true_rms));
  EXPECT_EQ(back->calibration[1].true_rms, 0.03);
  EXPECT_EQ(back->non_finite_samples, 3u);
}

TEST(StudyFiles, DamagedAndForeignRunsAreRefusedWithTheirPlace) {
  const std::string text = run_json(awkward_run(), "the key");
  std::string message;
  EXPECT_FALSE(read_back(text, "another key", &message));
  EXPECT_NE(message.find("run.json#/key: expected the key of this study"), std::string::npos);
  for (size_t length = 0; length + 2 < text.size(); length += 7) {
    EXPECT_FALSE(read_back(text.substr(0, length), "the key")) << length;
  }
  for (const char* wrong : {"[]", "null", "{}", "{\"key\": \"the key\"}"}) {
    EXPECT_FALSE(read_back(wrong, "the key")) << wrong;
  }
  const std::pair<const char*, nlohmann::json> damages[] = {
      {"/seed", "x"},
      {"/seed", 4294967296},
      {"/seed", -1},
      {"/status", "failed"},
      {"/reason", 3},
      {"/checkpoints", nlohmann::json::array()},
      {"/checkpoints", 1},
      {"/checkpoints/0/mse", "x"},
      {"/checkpoints/0/samples", 0.5},
      {"/calibration/1", {1}},
      {"/calibration/1/estimate", nullptr}};
  for (const auto& [pointer, value] : damages) {
    nlohmann::json json = nlohmann::json::parse(text);
    json[nlohmann::json::json_pointer(pointer)] = value;
    EXPECT_FALSE(read_back(json.dump(), "the key", &message)) << pointer << " = " << value;
    EXPECT_TRUE(message.starts_with(std::string("run.json#") + pointer + ": ")) << message;
  }
}

StudyResults small_study() {
  StudyResults r;
  r.settings.budgets = {0.1};
  r.settings.baseline = "a,b";
  r.settings.seeds = 1;
  r.methods.resize(2);
  r.methods[0].name = "a,b";
  r.methods[1].name = "c";
  r.runs = {awkward_run(), StudyRun{}};
  r.runs[1].method = 1;
  r.runs[1].status = StudyRunStatus::kFailed;
  r.runs[1].reason = "it said \"no\",\nand left";
  return r;
}

TEST(StudyFiles, CsvHasARowForEachCheckpointAndFailure) {
  const std::string csv = study_csv(small_study());
  const size_t columns = size_t(std::count(csv.begin(), csv.begin() + long(csv.find('\n')), ','));
  EXPECT_NE(csv.find("\n\"a,b\","), std::string::npos) << csv;
  EXPECT_NE(csv.find("\"it said \"\"no\"\",\nand left\""), std::string::npos) << csv;
  EXPECT_EQ(csv.find("nan"), std::string::npos) << "what has no value is empty";
  const std::string failed = csv.substr(csv.find("\nc,") + 1);
  // The quoted reason contains one comma and one newline.
  EXPECT_EQ(size_t(std::count(failed.begin(), failed.end(), ',')), columns + 1);
}

TEST(StudyFiles, JsonIsValidIfValuesAreMissing) {
  StudyResults results = small_study();
  nlohmann::json json = nlohmann::json::parse(study_json(results));
  EXPECT_TRUE(json["neyman_limits"].is_null());
  EXPECT_EQ(json["summary"][1]["failed_runs"], 1);
  EXPECT_TRUE(json["summary"][1]["signed_bias"][0].is_null());
  EXPECT_EQ(json["runs"][0]["checkpoints"][0]["samples"], (uint64_t(1) << 53) - 1);
  results.methods[0].name = "not UTF-8: \xff";
  EXPECT_TRUE(nlohmann::json::accept(study_json(results)));
  EXPECT_TRUE(nlohmann::json::accept(study_json({})));
}

TEST(StudyFiles, TableListsFailures) {
  const std::string table = study_table(small_study());
  EXPECT_NE(table.find("c: 1 run failed: it said"), std::string::npos) << table;
}

}  // namespace
}  // namespace emberline
