// Tests --snapshots, which writes intermediate pictures of a progressive render.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

class Snapshots : public CommandTest {
 protected:
  Words progressive(const Words& more = {}) {
    return render_words(Words{"--driver", "bisection", "--size", "96x64", "--snapshots",
                              path("shots"), "--report", path("r.json")} +
                        more);
  }
  Words shots() const {
    Words names;
    for (const auto& entry : std::filesystem::directory_iterator(path("shots"))) {
      names.push_back(entry.path().filename().string());
    }
    std::erase(names, "emberline-snapshots.json");  // the list of the files that Emberline wrote
    std::ranges::sort(names);
    return names;
  }
};

TEST_F(Snapshots, DefaultMomentsInOrder) {
  render(progressive());
  EXPECT_EQ(shots(),
            (Words{"000_first.png", "001_0001pct.png", "002_0002pct.png", "003_0005pct.png",
                   "004_0010pct.png", "005_0025pct.png", "006_0035pct.png", "007_0050pct.png",
                   "008_0075pct.png", "009_0100pct.png", "refinement.gif"}));
  const nlohmann::json list = read_json("r.json")["snapshots"];
  ASSERT_EQ(list.size(), 10u);
  const double percents[] = {0, 1, 2, 5, 10, 25, 35, 50, 75, 100};
  double completion = 0, elapsed = 0;
  for (size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(list[i]["file"], shots()[i]);
    // The render pauses at least once in every hundredth of the frame.
    EXPECT_GE(list[i]["completion"].get<double>(), percents[i] / 100);
    EXPECT_LE(list[i]["completion"].get<double>(), percents[i] / 100 + 0.0101);
    EXPECT_GE(list[i]["completion"].get<double>(), completion);
    EXPECT_GE(list[i]["elapsed_s"].get<double>(), elapsed);
    EXPECT_TRUE(list[i]["rmse"].is_null());
    completion = list[i]["completion"];
    elapsed = list[i]["elapsed_s"];
    const BytePicture picture = read_bytes_picture(path("shots/" + shots()[i]));
    EXPECT_EQ(picture.width, 96);
    EXPECT_EQ(picture.height, 64);
  }
  EXPECT_EQ(list.back()["samples"], 96u * 64u);
  EXPECT_LE(elapsed, read_json("r.json")["time"]["render_s"].get<double>());
}

TEST_F(Snapshots, TheAnimationHasAFrameForEach) {
  render(progressive({"--snapshot-at", "first,10%,100%"}));
  const std::vector<BytePicture> frames = read_animation(path("shots/refinement.gif"));
  for (const BytePicture& frame : frames) {
    EXPECT_EQ(frame.width, 96);
    EXPECT_EQ(frame.height, 64);
  }
  EXPECT_EQ(frames.size(), 3u);
}

// Moments may be times, sample counts and fractions, in any order. The last snapshot is the
// finished frame.
TEST_F(Snapshots, MomentsOfEveryKind) {
  render(progressive({"--spp", "8", "--snapshot-at", "8spp,2.5%,0.000001s,first",
                      "--snapshot-format", "exr", "--bucket-size", "1"}));
  EXPECT_EQ(shots().size(), 9u);
  const nlohmann::json list = read_json("r.json")["snapshots"];
  ASSERT_EQ(list.size(), 4u);
  EXPECT_EQ(list[0]["samples"], 1);
  EXPECT_EQ(list[2]["file"], "002_0002.500pct.png");
  EXPECT_EQ(list[3]["file"], "003_0008spp.png");
  const ExrPicture last = read_exr(path("shots/003_0008spp.exr"));
  const ExrPicture frame = read_exr(path("out.exr"));
  EXPECT_EQ(last.tile_size, 16);
  for (const char* channel : {"R", "G", "B", "A"}) {
    EXPECT_EQ(last.channels.at(channel), frame.channels.at(channel)) << channel;
  }
}

// Each pass doubles the samples, so the last pass is half of the frame. A snapshot within a pass
// must be taken after the next part of the pass.
TEST_F(Snapshots, AreOnTimeInLongPasses) {
  render(progressive({"--spp", "128", "--snapshot-at", "20spp,33spp,100spp"}));
  const nlohmann::json list = read_json("r.json")["snapshots"];
  ASSERT_EQ(list.size(), 3u);
  constexpr uint64_t kPixels = 96 * 64, kPart = 4096;
  const uint64_t wanted[] = {20 * kPixels, 33 * kPixels, 100 * kPixels};
  for (size_t i = 0; i < list.size(); ++i) {
    EXPECT_GE(list[i]["samples"].get<uint64_t>(), wanted[i]);
    EXPECT_LT(list[i]["samples"].get<uint64_t>(), wanted[i] + kPart);
  }
}

// Snapshots must not wait for the end of a pass. Pauses between passes would be in time for at most
// two of these snapshots, because each pass takes twice as long as the pass before it, and the last
// snapshot's time is only three times that of the first. On a busy machine, some snapshots may be
// late.
TEST_F(Snapshots, AreTakenAtTheirTimes) {
  const auto time = [](size_t i) { return (0.2 + 0.05 * double(i)) * kSanitizerSlowdown; };
  std::string times;
  for (size_t i = 0; i < 9; ++i) times += (i ? "," : "") + std::to_string(time(i)) + "s";
  render(progressive({"--spp", "65536", "--time-limit", std::to_string(kSanitizerSlowdown),
                      "--threads", "1", "--snapshot-at", times}));
  const nlohmann::json list = read_json("r.json")["snapshots"];
  ASSERT_EQ(list.size(), 9u);
  std::set<double> pauses;
  for (size_t i = 0; i < list.size(); ++i) {
    const double elapsed = list[i]["elapsed_s"];
    EXPECT_GE(elapsed, time(i) - 1e-9);
    pauses.insert(elapsed);
  }
  EXPECT_GE(pauses.size(), 5u);
}

TEST_F(Snapshots, AreMeasuredAgainstTheReference) {
  render(render_words({"--size", "96x64", "--spp", "4", "-o", path("ref.exr")}));
  render(progressive(
      {"--spp", "4", "--snapshot-at", "first,50%,100%,4spp", "--reference", path("ref.exr")}));
  const nlohmann::json list = read_json("r.json")["snapshots"];
  ASSERT_EQ(list.size(), 4u);
  EXPECT_GT(list[0]["rmse"].get<double>(), 0.0);
  EXPECT_GT(list[0]["mse"].get<double>(), list[2]["mse"].get<double>());
  // With equal samples, the error must be zero (law 2 in renderer/README.md).
  for (const char* metric : {"rmse", "mse", "relmse"}) {
    EXPECT_EQ(list[3][metric].get<double>(), 0.0) << metric;
  }
}

TEST_F(Snapshots, ErrorsAreReportedBeforeTheSceneIsLoaded) {
  scene();
  write("file", "irreplaceable");
  const auto words = [&](const Words& more) {
    return Words{"render", path("none.glb"), "-o", path("out.exr"), "--driver", "bisection"} + more;
  };
  expect_failure(words({"--driver", "bucket", "--snapshots", path("shots")}), 2,
                 {"--snapshots", "bucket", "--driver bisection or adaptive"});
  expect_failure(words({"--snapshots", path("file")}), 1, {"--snapshots", "file"});
  expect_failure(words({"--snapshots", path("new/shots")}), 1, {"--snapshots", "new/shots"});
  expect_failure(words({"--snapshots", path("shots"), "--reference", path("no.exr")}), 3,
                 {"no.exr"});
  for (const char* option : {"--snapshot-at", "--snapshot-format", "--reference"}) {
    expect_failure(words({option, std::string(option) == "--snapshot-format" ? "exr" : "x"}), 2,
                   {option, "requires --snapshots"});
  }
  // If the render is refused, the folder that it created must be removed.
  expect_failure(words({"--snapshots", path("shots")}), 3, {"none.glb"});
}

TEST_F(Snapshots, ReplaceOnlyTheirOwnFiles) {
  write("shots/notes.txt", "irreplaceable");
  const Words words = progressive({"--snapshot-at", "first,50%"});
  render(words);
  render(words);
  EXPECT_EQ(shots(), (Words{"000_first.png", "001_0050pct.png", "notes.txt", "refinement.gif"}));
  for (const char* name : {"refinement.gif", "007_0050pct.png", "000_first.exr"}) {
    const std::string folder = std::string("of_") + name;
    write(folder + "/" + name, "irreplaceable");
    expect_failure(progressive({"--snapshot-at", "first,50%", "--snapshots", path(folder)}), 2,
                   {"--snapshots", name, "move it away"});
    EXPECT_EQ(read_bytes(path(folder + "/" + name)).size(), 13u);
  }
}

TEST_F(Snapshots, AReferenceOfAnotherSizeIsRefused) {
  render(render_words({"--size", "32x16", "-o", path("ref.exr")}));
  expect_failure(progressive({"--reference", path("ref.exr")}), 3,
                 {"ref.exr", "32 x 16", "96 x 64"});
}

// Returns whether another user can load the program's libraries. In a folder such as /root, this is
// not possible.
bool is_open_to_others(std::filesystem::path folder) {
  using std::filesystem::perms;
  for (; folder != folder.root_path(); folder = folder.parent_path()) {
    const perms allowed = std::filesystem::status(folder).permissions();
    if ((allowed & perms::others_exec) == perms::none) return false;
  }
  return true;
}

TEST_F(Snapshots, WriteProtectedFolder) {
  if (!is_open_to_others(std::filesystem::path(EMBERLINE_BINARY).parent_path())) {
    GTEST_SKIP() << "other users cannot enter the folder of " << EMBERLINE_BINARY;
  }
  scene();
  std::filesystem::create_directories(path("shots"));
  using std::filesystem::perms;
  std::filesystem::permissions(folder_.path(), perms::all);
  std::filesystem::permissions(path("shots"), perms::owner_read | perms::owner_exec |
                                                  perms::others_read | perms::others_exec);
  expect_failure(progressive(), 1, {"shots"}, {.unprivileged = true});
  std::filesystem::permissions(path("shots"), perms::owner_all);
}

}  // namespace
}  // namespace emberline::test
