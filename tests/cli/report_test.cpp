// Tests report.json. Every documented key must have its type, and totals must match the picture.
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <numeric>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Report : public CommandTest {
 protected:
  nlohmann::json report(const Words& words) {
    result_ = render(render_words(words + Words{"--report", path("report.json")}));
    return read_json("report.json");
  }
  RunResult result_;
};

TEST_F(Report, HasEveryDocumentedKey) {
  const nlohmann::json json = report({"--spp", "4"});
  using Type = nlohmann::json::value_t;
  const std::map<std::string, Type> expected = {
      {"/time/start_s", Type::number_float},
      {"/time/setup_s", Type::number_float},
      {"/time/load_s", Type::number_float},
      {"/time/build_s", Type::number_float},
      {"/time/render_s", Type::number_float},
      {"/time/write_s", Type::number_float},
      {"/time/wall_s", Type::number_float},
      {"/time/cpu_s", Type::number_float},
      {"/time/render_cpu_s", Type::number_float},
      {"/time/first_sample_s", Type::number_float},
      {"/time/first_sample_cpu_s", Type::number_float},
      {"/samples/total", Type::number_unsigned},
      {"/samples/min", Type::number_unsigned},
      {"/samples/mean", Type::number_float},
      {"/samples/max", Type::number_unsigned},
      {"/samples/pixels_without", Type::number_unsigned},
      {"/rays/camera", Type::number_unsigned},
      {"/rays/scatter", Type::number_unsigned},
      {"/rays/shadow", Type::number_unsigned},
      {"/rays/total", Type::number_unsigned},
      {"/memory/peak_rss_bytes", Type::number_unsigned},
      {"/memory/geometry_bytes", Type::number_unsigned},
      {"/memory/bvh_bytes", Type::number_unsigned},
      {"/memory/texture_bytes", Type::number_unsigned},
      {"/memory/texture_file_bytes", Type::number_unsigned},
      {"/memory/film_bytes", Type::number_unsigned},
      {"/numerics/non_finite_samples", Type::number_unsigned},
      {"/optics/rays_ended_at_panes", Type::number_unsigned},
      {"/optics/solids_forgotten", Type::number_unsigned},
      {"/optics/light_samples_blocked_by_glass", Type::null},  // the scene has no such light
      {"/error/estimator", Type::string},
      {"/error/estimate", Type::null},  // uniform sampling has no estimate
      {"/warnings", Type::array},
      {"/features", Type::array},
      {"/gltf/used", Type::array},
      {"/gltf/approximated", Type::array},
      {"/gltf/ignored", Type::array},
      {"/passes", Type::array},
      {"/passes/0/elapsed_s", Type::number_float},
      {"/passes/0/samples", Type::number_unsigned},
      {"/passes/0/error_estimate", Type::null},
      {"/settings", Type::object},
      {"/versions", Type::object},
      {"/output", Type::array},
      {"/heatmaps", Type::array},
      {"/snapshots", Type::array},
      {"/time/snapshots_s", Type::number_float},
      {"/stopped", Type::boolean},
      {"/stop_cause", Type::null},
      {"/exit_code", Type::number_integer},
  };
  for (const auto& [pointer, type] : expected) {
    const nlohmann::json::json_pointer place(pointer);
    ASSERT_TRUE(json.contains(place)) << pointer;
    const Type found = json.at(place).type();
    const bool whole = found == Type::number_unsigned && type == Type::number_integer;
    EXPECT_TRUE(found == type || whole) << pointer << ": " << json.at(place);
  }
  EXPECT_EQ(json["exit_code"], 0);
  EXPECT_EQ(json["stopped"], false);
  EXPECT_FALSE(json["features"].empty());
  for (const auto& feature : json["features"]) EXPECT_TRUE(feature.is_string());
}

TEST_F(Report, SamplesAndRaysAddUp) {
  const nlohmann::json json =
      report({"--size", "37x21", "--spp", "6", "--crop", "3,2,30,20", "--max-depth", "4"});
  const ExrPicture picture = read_exr(path("out.exr"));
  const std::vector<float>& samples = picture.channels.at("samples");
  const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
  EXPECT_EQ(sum, 6.0 * 27 * 18);
  EXPECT_EQ(json["samples"]["total"], uint64_t(sum));
  EXPECT_EQ(json["samples"]["min"], 6);
  EXPECT_EQ(json["samples"]["mean"], 6.0);
  EXPECT_EQ(json["samples"]["max"], 6);
  const auto& rays = json["rays"];
  EXPECT_EQ(rays["camera"], uint64_t(sum));
  EXPECT_GT(rays["scatter"], 0u);
  EXPECT_GT(rays["shadow"], 0u);
  EXPECT_EQ(rays["total"].get<uint64_t>(), rays["camera"].get<uint64_t>() +
                                               rays["scatter"].get<uint64_t>() +
                                               rays["shadow"].get<uint64_t>());
  EXPECT_EQ(json["passes"].back()["samples"], json["samples"]["total"]);
  EXPECT_EQ(json["numerics"]["non_finite_samples"], 0);
}

// The times in the report must cover everything that the command does, including snapshots and
// reading a reference.
TEST_F(Report, TimesAddUp) {
  render(render_words({"--size", "256x256", "-o", path("reference.exr")}));
  const Words more = {"--size", "256x256", "--spp", "8", "-o", path("a.png")};
  const Words shots = {"--snapshots", path("shots"), "--reference", path("reference.exr")};
  for (const Words& words :
       {more, more + Words{"--driver", "bisection"} + shots,
        more + Words{"--driver", "adaptive", "--aov", "variance,stop"} + shots}) {
    const nlohmann::json json = report(words);
    const auto& time = json["time"];
    double sum = 0;
    for (const char* part :
         {"setup_s", "load_s", "build_s", "render_s", "write_s", "snapshots_s"}) {
      EXPECT_GE(time[part].get<double>(), 0.0) << part;
      sum += time[part].get<double>();
    }
    const double wall = time["wall_s"];
    EXPECT_GE(wall, sum - 1e-9);
    // Another process may take the processor for some milliseconds between two clock readings.
    EXPECT_LE(wall - sum, std::max(0.02 * wall, 0.01 * kSanitizerSlowdown)) << time;
    EXPECT_LE(wall, result_.seconds);
    // The kernel rounds the start of a process to 10 ms.
    EXPECT_LE(wall + time["start_s"].get<double>(), result_.seconds + 0.011);
    EXPECT_GT(time["cpu_s"].get<double>(), 0.0);
  }
}

// The counts in the report must match the picture, no matter how the frame ends.
TEST_F(Report, CountsMatchThePictureForEveryDriver) {
  struct Ending {
    const char* name;
    Words words;
    int stop_signal;  // 0 if no signal is sent
  };
  const std::vector<Ending> endings = {
      {"whole", {"--size", "40x24", "--spp", "12"}, 0},
      {"crop", {"--size", "64x48", "--crop", "5,7,50,41", "--spp", "12"}, 0},
      {"time limit", {"--size", "256x256", "--spp", "100000", "--time-limit", "0.1"}, 0},
      {"stopped", {"--size", "256x256", "--spp", "100000", "--verbose"}, SIGINT},
  };
  for (const char* driver : {"bucket", "bisection", "adaptive"}) {
    for (const Ending& ending : endings) {
      SCOPED_TRACE(std::string(driver) + ", " + ending.name);
      const Words words = render_words(
          Words{"--driver", driver, "--bucket-size", "16", "--report", path("report.json")} +
          ending.words);
      if (ending.stop_signal) {
        Process process(words, {.folder = folder_.path()});
        ASSERT_TRUE(process.wait_until_busy("loaded in", 0.2 * kSanitizerSlowdown))
            << process.error_so_far();
        process.send(ending.stop_signal);
        ASSERT_EQ(process.wait().exit_code, 130);
      } else {
        render(words);
      }
      const nlohmann::json json = read_json("report.json");
      const std::vector<float> samples = read_exr(path("out.exr")).channels.at("samples");
      const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
      EXPECT_GT(sum, 0.0);
      EXPECT_EQ(json["samples"]["total"], uint64_t(sum));
      EXPECT_EQ(json["samples"]["min"], uint64_t(*std::ranges::min_element(samples)));
      EXPECT_EQ(json["samples"]["max"], uint64_t(*std::ranges::max_element(samples)));
      EXPECT_DOUBLE_EQ(json["samples"]["mean"], sum / double(samples.size()));
      EXPECT_EQ(json["rays"]["camera"], uint64_t(sum));
      EXPECT_EQ(json["passes"].back()["samples"], uint64_t(sum));
    }
  }
}

// The estimate of a pass describes the picture at the end of the pass. The first estimate is that
// of the pilot pass, and the next pass is planned with it. The last estimate is that of the frame.
TEST_F(Report, EstimatesBelongToTheirPasses) {
  const nlohmann::json json =
      report({"--driver", "adaptive", "--size", "96x96", "--spp", "256", "--seed", "2"});
  const auto& passes = json["passes"];
  EXPECT_EQ(passes.back()["error_estimate"], json["error"]["estimate"]);
  ASSERT_GE(passes.size(), 4u) << passes;
  EXPECT_TRUE(passes[0]["error_estimate"].is_null()) << passes;  // one sample per pixel is too few
  for (size_t i = 1; i < passes.size(); ++i) {
    ASSERT_TRUE(passes[i]["error_estimate"].is_number()) << passes;
    // If the last round has few samples, it may change the estimate by less than the noise.
    if (i > 1) {
      EXPECT_LT(passes[i]["error_estimate"], 1.01 * double(passes[i - 1]["error_estimate"]));
    }
  }
  EXPECT_LT(passes.back()["error_estimate"], 0.3 * double(passes[1]["error_estimate"]));
}

TEST_F(Report, ListsWarningsEvenWithQuiet) {
  GltfBuilder gltf = lamp_scene();
  gltf.root["extensionsUsed"] = {"EXT_made_up"};
  gltf.root["extensions"]["EXT_made_up"] = {{"x", 1}};
  gltf.write_glb(path("scene.glb"));
  const nlohmann::json loud = report({});
  const nlohmann::json quiet = report({"--quiet"});
  EXPECT_EQ(loud["warnings"], quiet["warnings"]);
  ASSERT_EQ(loud["warnings"].size(), 1u) << loud["warnings"];
  EXPECT_NE(loud["warnings"][0].get<std::string>().find("EXT_made_up"), std::string::npos);
}

// The processor time of the render must be part of the total. The first sample must come after
// loading and building, and before most of the render.
TEST_F(Report, FirstSampleAndProcessorTimeOfTheRender) {
  const nlohmann::json json = report({"--size", "512x512", "--spp", "16", "--threads", "2"});
  const auto& time = json["time"];
  const auto seconds = [&time](const char* key) { return time[key].get<double>(); };
  // The kernel rounds the start of a process to 10 ms, and sums of its times to 1 ms.
  constexpr double kTick = 0.011;
  EXPECT_GT(seconds("render_cpu_s"), 0.0);
  EXPECT_LE(seconds("render_cpu_s"), seconds("cpu_s"));
  // Allows for two workers, and for the thread of the display, which wakes up occasionally.
  EXPECT_LE(seconds("render_cpu_s"), 2.1 * seconds("render_s") + kTick);
  EXPECT_GE(seconds("first_sample_s"), seconds("load_s") + seconds("build_s") - kTick);
  EXPECT_LE(seconds("first_sample_s"), result_.seconds + kTick);
  // Each worker first reports samples after 2048 of the 262144 x 16 samples, so most of the work is
  // still to be done.
  EXPECT_LE(seconds("first_sample_cpu_s"),
            seconds("cpu_s") - 0.9 * seconds("render_cpu_s") + kTick);
}

TEST_F(Report, MemoryIsThatOfThisProcess) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer's own memory is many times ours";
  const nlohmann::json json = report({});
  const double reported = json["memory"]["peak_rss_bytes"];
  // The kernel's number for the process includes the test program's memory before exec.
  EXPECT_GT(reported, 1e6);
  EXPECT_LE(reported, 1.02 * double(result_.peak_rss_bytes));
  // The parent process now has 256 MiB more memory, which must not be counted.
  std::vector<char> ballast(size_t(1) << 28, 1);
  const nlohmann::json again = report({});
  EXPECT_LT(again["memory"]["peak_rss_bytes"].get<double>(), double(ballast.size()));
  EXPECT_NEAR(again["memory"]["peak_rss_bytes"].get<double>(), reported, 0.2 * reported);
}

TEST_F(Report, ListsTheFeaturesOfTheScene) {
  const auto listed = [](const nlohmann::json& json, const std::string& word) {
    for (const auto& feature : json["features"]) {
      if (feature.get<std::string>().find(word) != std::string::npos) return true;
    }
    return false;
  };
  const nlohmann::json plain = report({});
  EXPECT_TRUE(listed(plain, "emission")) << plain["features"];
  EXPECT_FALSE(listed(plain, "texture")) << plain["features"];
  EXPECT_FALSE(listed(plain, "instanc")) << plain["features"];
  EXPECT_FALSE(listed(plain, "environment")) << plain["features"];
}

TEST_F(Report, SettingsAndListsOfTheFile) {
  GltfBuilder gltf = lamp_scene();
  gltf.root["extensionsUsed"] = {"KHR_materials_emissive_strength", "EXT_made_up"};
  gltf.root["materials"][1]["extensions"]["KHR_materials_emissive_strength"] = {
      {"emissiveStrength", 2}};
  gltf.root["extensions"]["EXT_made_up"] = {{"x", 1}};
  gltf.write_glb(path("scene.glb"));
  const nlohmann::json json = report({"--threads", "2", "--seed", "5"});
  EXPECT_EQ(json["gltf"]["used"], nlohmann::json({"KHR_materials_emissive_strength"}));
  ASSERT_EQ(json["gltf"]["ignored"].size(), 1u) << json["gltf"];
  EXPECT_NE(json["gltf"]["ignored"][0].get<std::string>().find("EXT_made_up"), std::string::npos);
  // The warning must appear only once.
  size_t warnings = 0;
  for (const std::string& line : result_.error_lines()) {
    warnings += line.find("EXT_made_up") != std::string::npos;
  }
  EXPECT_EQ(warnings, 1u) << result_.err;
  EXPECT_EQ(json["settings"]["threads"], 2);
  EXPECT_EQ(json["settings"]["seed"], "5");
  EXPECT_EQ(json["settings"]["camera"], "main");
  EXPECT_EQ(json["settings"]["size"], nlohmann::json({16, 16}));
  EXPECT_EQ(json["output"], nlohmann::json({path("out.exr")}));
}

TEST_F(Report, MayGoToAPipe) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const int reader = ::open(path("pipe").c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  render(render_words({"--quiet", "--report", path("pipe")}));
  std::string text(1 << 16, '\0');
  text.resize(size_t(std::max(ssize_t(0), ::read(reader, text.data(), text.size()))));
  ::close(reader);
  EXPECT_FALSE(nlohmann::json::parse(text, nullptr, false).is_discarded()) << text;
  EXPECT_TRUE(std::filesystem::is_fifo(path("pipe")));
}

}  // namespace
}  // namespace emberline::test
