// Tests progress on a terminal and in the log of a farm, with and without --quiet.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Progress : public CommandTest {
 protected:
  // Updates come every tenth of a second. Even on a fast machine, this frame takes long enough for
  // an update.
  Words long_render(const Words& more = {}) {
    return render_words(Words{"--size", "320x250", "--spp", "16", "--threads", "1"} + more);
  }
};

TEST_F(Progress, WritesPlainLinesToALog) {
  const RunResult result = render(long_render());
  EXPECT_EQ(result.err.find('\r'), std::string::npos);
  EXPECT_EQ(result.err.find('\033'), std::string::npos);
  const std::regex line(
      R"(rendering +[0-9.]+ %  [0-9.]+ (us|ms|s|min [0-9]+ s)(, .+ left)?  \([0-9.]+ M samples/s\))");
  size_t progress = 0;
  for (const std::string& text : result.error_lines()) {
    if (!text.starts_with("rendering ")) continue;
    ++progress;
    EXPECT_TRUE(std::regex_match(text, line)) << text;
  }
  EXPECT_GE(progress, 1u) << result.err;
  EXPECT_LE(progress, 11u) << result.err;
  EXPECT_NE(result.err.find("rendered 1280000 samples"), std::string::npos) << result.err;
}

// With a threshold, the number of samples is not known beforehand. The time left is estimated from
// the fraction of finished buckets.
TEST_F(Progress, BucketsWithAThresholdShowTheTimeLeft) {
  // This frame has no --spp, because that would set a budget.
  const RunResult result =
      run({"render", scene(), "-o", path("out.exr"), "--size", "160x160", "--noise-threshold",
           "0.00001", "--max-spp", "64", "--bucket-size", "16", "--threads", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_TRUE(std::regex_search(result.err, std::regex(R"(rendering +[0-9.]+ %.* left )")))
      << result.err;
}

// Returns the lines of a terminal that overwrite each other, without the escape codes that clear a
// line.
Words drawn_lines(const std::string& text) {
  Words lines;
  size_t at = 0;
  while (at < text.size()) {
    const size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    std::string line = text.substr(at, end - at);
    for (size_t code; (code = line.find("\033[K")) != std::string::npos;) line.erase(code, 3);
    if (!line.empty()) lines.push_back(line);
    at = end + 1;
  }
  return lines;
}

TEST_F(Progress, ABarOnATerminal) {
  for (const int columns : {80, 50, 20}) {
    const RunResult result = run(long_render(), {.terminal_columns = columns});
    ASSERT_EQ(result.exit_code, 0) << result.describe();
    EXPECT_NE(result.err.find('\r'), std::string::npos);
    size_t bars = 0, updates = 0;
    for (const std::string& line : drawn_lines(result.err)) {
      if (line.find(" %") == std::string::npos) continue;
      ++updates;
      bars += line.find('[') != std::string::npos;
      // A terminal would wrap a longer line, and the next line could not overwrite it.
      EXPECT_LT(line.size(), size_t(columns)) << line;
    }
    EXPECT_GE(updates, 1u) << result.err;
    EXPECT_TRUE(columns < 80 || bars == updates);
    // The bar must be cleared before the last message, which must be alone in its line.
    EXPECT_NE(result.err.find("\r\033[Krendered "), std::string::npos) << result.err;
  }
}

TEST_F(Progress, ATerminalWithoutCursorGetsPlainLines) {
  const RunResult result =
      run(long_render(), {.environment = {{"TERM", "dumb"}}, .terminal_columns = 80});
  EXPECT_EQ(result.err.find('\033'), std::string::npos) << result.err;
}

TEST_F(Progress, QuietIsSilent) {
  EXPECT_EQ(render(render_words({"-q", "-o", path("q.png")})).err, "");
  const RunResult piped = render(render_words({"--quiet", "-o", path("a.png")}));
  EXPECT_EQ(piped.err, "");
  // Without --quiet, this render would take long enough to draw a bar.
  const RunResult terminal = run(long_render({"--quiet"}), {.terminal_columns = 80});
  EXPECT_EQ(terminal.exit_code, 0);
  EXPECT_EQ(terminal.err, "");
  // Errors must still be printed.
  expect_failure({"render", path("none.glb"), "-o", path("out.exr"), "--quiet"}, 3, {"none.glb"});
}

TEST_F(Progress, VerboseListsSceneFeatures) {
  const std::string normal = render(render_words({})).err;
  const std::string verbose = render(render_words({"--verbose", "--report", path("r.json")})).err;
  const nlohmann::json report = read_json("r.json");
  for (const auto& feature : report["features"]) {
    EXPECT_NE(verbose.find(feature.get<std::string>()), std::string::npos) << verbose;
    EXPECT_EQ(normal.find(feature.get<std::string>()), std::string::npos) << normal;
  }
  // The log must name the machine and the version.
  const auto machine = report["machine"]["instruction_sets"].get<std::string>();
  EXPECT_NE(verbose.find(report["machine"]["host"].get<std::string>() + ": " + machine),
            std::string::npos)
      << verbose;
  EXPECT_NE(verbose.find("emberline " + report["versions"]["emberline"].get<std::string>()),
            std::string::npos);
}

TEST_F(Progress, UnreadLogDoesNotEndTheRender) {
  // This is like `emberline render ... 2>&1 | head -1`, where head stops reading after one line.
  const RunResult result = run(long_render(), {.stderr_reader_gone = true});
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(files(), (Words{"out.exr", "scene.glb"}));
  // A reader may also disappear during loading.
  const RunResult loading =
      run(render_words({"--verbose", "-o", path("b.png")}), {.stderr_reader_gone = true});
  EXPECT_EQ(loading.exit_code, 0) << loading.describe();
  EXPECT_EQ(files(), (Words{"b.png", "out.exr", "scene.glb"}));
}

}  // namespace
}  // namespace emberline::test
