// Tests the folder of `emberline study`: which files in it belong to the study, which studies are
// resumed, and which folders are refused.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "cli/study_fixture.h"

namespace emberline::test {
namespace {

TEST_F(Study, AFolderHoldsOneStudy) {
  const Words bucket = {"--drivers", "bucket"};
  study(study_words("s", bucket));
  const std::vector<Row> before = contents("s");
  // Further seeds and drivers extend the study.
  study(study_words("s", {"--drivers", "bucket,bisection", "--seeds", "3"}));
  const std::vector<Row> after = contents("s");
  EXPECT_EQ(after.size(), 18u);
  for (const Row& row : before) EXPECT_EQ(std::ranges::count(after, row), 1);
  for (const Words& other : {Words{"--spp", "1,2"}, Words{"--max-depth", "2"},
                             Words{"--size", "16x8"}, Words{"--reference-spp", "99"}}) {
    expect_failure(study_words("s", bucket + other), 2, {path("s"), "--restart"});
  }
  study(study_words("s", bucket + Words{"--spp", "1,2", "--restart"}));
  EXPECT_EQ(rows("s").size(), 4u);
}

// --restart may replace only files that the study has written.
TEST_F(Study, RestartKeepsForeignFiles) {
  const Words bucket = {"--drivers", "bucket"}, other = {"--spp", "1,2", "--restart"};
  study(study_words("s", bucket));
  const Words foreign = {"runs/notes.txt", "runs/bucket-sobol_0.json.bak", "runs/thesis.json",
                         "pictures/me.png", "notes.txt"};
  for (const std::string& name : foreign) write("s/" + name, "irreplaceable");
  std::filesystem::create_directories(path("s/runs/folder"));
  study(study_words("s", bucket + other));
  EXPECT_EQ(rows("s").size(), 4u);
  for (const std::string& name : foreign) {
    EXPECT_EQ(read_text(path("s/" + name)), "irreplaceable") << name;
  }
  EXPECT_TRUE(exists("s/runs/folder"));
}

TEST_F(Study, ForeignFolderIsRefused) {
  scene();
  // The folder must be refused even if the file in it has the name of a study's file.
  for (const char* name : {"settings.json", "runs/a.json", ".hidden", "study.csv"}) {
    const std::string folder = std::string("of_") + std::filesystem::path(name).stem().string();
    write(folder + "/" + name, "{\"key\": \"theirs\"}");
    for (const Words& more : {Words{}, Words{"--restart"}}) {
      expect_failure(study_words(folder, more), 2, {path(folder), "emberline-study.json", "new"});
    }
    EXPECT_EQ(read_text(path(folder + "/" + name)), "{\"key\": \"theirs\"}");
    expect_failure({"study", "--convergence", "--seeds", "3", "-o", path(folder)}, 2,
                   {path(folder), "emberline-study.json"});
  }
  // If a file in a study's folder has the name of a future output, it must not be replaced.
  study(study_words("s", {"--drivers", "bucket"}));
  write("s/pictures/bisection-sobol.exr", "irreplaceable");
  expect_failure(study_words("s", {"--drivers", "bisection"}), 2,
                 {path("s/pictures/bisection-sobol.exr"), "move it away"});
  // Links that lead out of the folder must not be followed.
  std::filesystem::create_directories(path("elsewhere"));
  std::filesystem::create_directories(path("linked"));
  std::filesystem::copy(path("s/emberline-study.json"), path("linked/emberline-study.json"));
  std::filesystem::create_symlink(path("elsewhere"), path("linked/runs"));
  expect_failure(study_words("linked", {"--drivers", "bucket"}), 2,
                 {path("linked/runs"), "symbolic link"});
  std::filesystem::remove(path("linked/runs"));
  write("precious.csv", "irreplaceable");
  std::filesystem::create_symlink(path("precious.csv"), path("linked/study.csv"));
  expect_failure(study_words("linked", {"--drivers", "bucket", "--restart"}), 2,
                 {path("linked/study.csv"), "move it away"});
  std::filesystem::create_symlink(path("nowhere"), path("dangling"));
  expect_failure(study_words("dangling"), 1, {path("dangling"), "cannot create the folder"});
}

// The test locks the folder, as another run does while it writes.
TEST_F(Study, FolderInUseIsRefused) {
  const Words bucket = {"--drivers", "bucket"};
  study(study_words("s", bucket));
  std::filesystem::create_directories(path("snapshots"));
  for (const auto& [folder, words] :
       {std::pair{"s", study_words("s", bucket + Words{"--restart"})},
        {"s", Words{"study", "--convergence", "--seeds", "3", "-o", path("s")}},
        {"snapshots", render_words({"--driver", "bisection", "--snapshots", path("snapshots")})}}) {
    const int descriptor = ::open(path(folder).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    ASSERT_EQ(::flock(descriptor, LOCK_EX | LOCK_NB), 0);
    expect_failure(words, 2, {path(folder), "another run"});
    ::close(descriptor);
  }
  EXPECT_EQ(rows("s").size(), 6u);
  study(study_words("s", bucket));
}

// The folder might come from another user, who has added files outside the folder to its list.
TEST_F(Study, ForgedFileListRemovesNothing) {
  study(study_words("s", {"--drivers", "bucket"}));
  write("precious.txt", "irreplaceable");
  write("outer/runs/precious.json", "irreplaceable");
  write("s/mine.txt", "irreplaceable");
  std::filesystem::create_directory_symlink(path("outer/runs"), path("s/outer"));
  std::filesystem::create_symlink(path("precious.txt"), path("s/runs/link.json"));
  nlohmann::json marker = read_json("s/emberline-study.json");
  for (const std::string& name :
       {std::string("../precious.txt"), path("precious.txt"),
        std::string("runs/../../precious.txt"), std::string("runs/../mine.txt"),
        std::string("outer/precious.json"), std::string("runs/link.json"), std::string("runs/"),
        std::string("runs/."), std::string("runs"), std::string(".."), std::string(""),
        std::string("runs//x")}) {
    marker["files"].push_back(name);
  }
  write("s/emberline-study.json", marker.dump());
  study(study_words("s", {"--drivers", "bucket", "--spp", "1,2", "--restart"}));
  for (const char* name : {"precious.txt", "outer/runs/precious.json", "s/mine.txt"}) {
    EXPECT_EQ(read_text(path(name)), "irreplaceable") << name;
  }
  EXPECT_TRUE(std::filesystem::is_symlink(path("s/runs/link.json")));
  EXPECT_TRUE(exists("s/runs"));
  // An invalid list must be reported.
  for (const auto& [text, message_parts] :
       {std::pair{"{\"emberline_folder\": 1, \"files\": [3]}", "#/files/0: "},
        {"{\"emberline_folder\": 2, \"files\": []}", "#/emberline_folder: "},
        {"[", "not valid JSON"}}) {
    write("s/emberline-study.json", text);
    expect_failure(study_words("s", {"--restart"}), 3,
                   {path("s/emberline-study.json"), message_parts});
  }
}

TEST_F(Study, ErrorsInDamagedFilesNameThePlace) {
  const Words bucket = study_words("s", {"--drivers", "bucket"});
  study(bucket);
  const std::vector<Row> before = contents("s");
  const std::string settings = read_text(path("s/settings.json"));
  for (const auto& [text, message_parts] :
       {std::pair{"{\"key\": 3}", "#/key: expected a string, found 3"},
        {"{}", "the required member \"key\" is missing"},
        {"{\"key\": \"a\", \"key\": \"b\"}", "#/key: the member appears twice"},
        {"", "not valid JSON"}}) {
    write("s/settings.json", text);
    expect_failure(bucket, 3, {path("s/settings.json"), message_parts, "--restart"});
    EXPECT_EQ(read_text(path("s/settings.json")), text);
  }
  write("s/settings.json", settings);
  nlohmann::json run = read_json("s/runs/bucket-sobol_0.json");
  run["checkpoints"][1]["mse"] = "small";
  write("s/runs/bucket-sobol_0.json", run.dump());
  write("s/runs/bucket-sobol_1.json", std::string(100000, '['));
  write("s/pace.json", "{\"key\": 1e400}");
  // This file is far larger than any picture of this frame, so the page must not read it as a
  // whole.
  std::filesystem::resize_file(path("s/pictures/bucket-sobol.png"), uintmax_t(1) << 40);
  const RunResult again = study(bucket);
  for (const char* message_parts :
       {"runs/bucket-sobol_0.json#/checkpoints/1/mse: expected a number", "the run is repeated",
        "nested deeper than 256", "pace.json#/key: a number is too large", "measured again"}) {
    EXPECT_NE(again.err.find(message_parts), std::string::npos)
        << message_parts << ": " << again.err;
  }
  EXPECT_EQ(contents("s"), before);
}

TEST_F(Study, CacheKeepsForeignFiles) {
  const Words cache = study_words("a", {"--drivers", "bucket", "--cache", path("cache")});
  study(cache);
  Words names;
  for (const auto& entry : std::filesystem::directory_iterator(path("cache"))) {
    names.push_back(entry.path().filename().string());
  }
  ASSERT_EQ(names.size(), 4u);
  for (const std::string& name : names) write("cache/" + name, "irreplaceable");
  const RunResult refused = run(cache);
  EXPECT_EQ(refused.exit_code, 2) << refused.describe();
  EXPECT_NE(refused.err.find("--cache"), std::string::npos) << refused.err;
  for (const std::string& name : names) {
    EXPECT_EQ(read_text(path("cache/" + name)), "irreplaceable") << name;
  }
}

TEST_F(Study, WriteProtectedFolder) {
  scene();
  std::filesystem::create_directories(path("s"));
  using std::filesystem::perms;
  std::filesystem::permissions(folder_.path(), perms::all);
  std::filesystem::permissions(
      path("s"), perms::owner_read | perms::owner_exec | perms::others_read | perms::others_exec);
  expect_failure(study_words("s"), 1, {path("s")}, {.unprivileged = true});
  std::filesystem::permissions(path("s"), perms::owner_all);
}

}  // namespace
}  // namespace emberline::test
