// Saves, resumes, extends and merges frames through the library.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "renderer/api/emberline.h"

namespace emberline::api {
namespace {

namespace fs = std::filesystem;

class LibraryCheckpoints : public ::testing::Test {
 protected:
  void SetUp() override {
    set_log([](Message, std::string_view) {});
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override {
    set_log({});
    fs::remove_all(folder_);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static Settings small(const std::string& driver) {
    return Settings()
        .set("size", "24x16")
        .set("max-depth", "3")
        .set("driver", driver)
        .set("spp", "8");
  }
  static Scene box(const Settings& settings) {
    return Scene(EMBERLINE_SCENES "/cornell_box.glb", settings);
  }

  const fs::path folder_ =
      fs::path(::testing::TempDir()) /
      ("library_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

// A frame that was stopped and resumed is identical, bit for bit, to a frame that never stopped.
TEST_F(LibraryCheckpoints, StoppedFrameResumes) {
  for (const char* const driver : {"bucket", "bisection", "adaptive"}) {
    const Settings settings =
        small(driver).set("size", "64x64").set("spp", "24").set("bucket-size", "16");
    const Scene scene = box(settings);
    const Picture whole = render(scene, settings);
    RenderFiles files = RenderFiles::at(path(driver));
    std::stop_source stop;
    const auto watch = [&](const Progress& now) {
      if (now.samples >= 64 * 64 * 4) stop.request_stop();
    };
    const Picture part = render(files, scene, settings, {}, stop.get_token(), watch);
    ASSERT_FALSE(part.complete) << driver;
    ASSERT_TRUE(fs::exists(files.checkpoint)) << driver;
    files.resume = true;
    uint64_t before = 0;
    const Picture rest = render(files, scene, settings, {}, {}, [&](const Progress& now) {
      if (before == 0) before = now.samples;
    });
    EXPECT_EQ(rest.values, whole.values) << driver;
    EXPECT_TRUE(rest.complete);
    EXPECT_GT(before, 64u * 64) << driver << ": went on";
    EXPECT_FALSE(fs::exists(files.checkpoint)) << "the frame is done";
  }
}

// The frame is abandoned, or its observer throws, before the first scheduled save of the
// checkpoint. The checkpoint is written all the same.
TEST_F(LibraryCheckpoints, AbandonedFrameResumes) {
  for (const char* const driver : {"bucket", "bisection", "adaptive"}) {
    for (const bool throws : {false, true}) {
      const Settings settings =
          small(driver).set("size", "64x64").set("spp", "24").set("bucket-size", "16");
      const Scene scene = box(settings);
      RenderFiles files = RenderFiles::at(path(driver));
      std::stop_source give_up;
      const auto watch = [&](const Progress& now) {
        if (now.samples < 64 * 64 * 4) return;
        if (throws) throw std::out_of_range("the watcher's");
        give_up.request_stop();
      };
      if (throws) {
        EXPECT_THROW(render(files, scene, settings, {}, {}, watch), std::out_of_range) << driver;
      } else {
        EXPECT_THROW(render(files, scene, settings, {}, {}, watch, give_up.get_token()), Stopped)
            << driver;
      }
      ASSERT_TRUE(fs::exists(files.checkpoint)) << driver << throws;
      files.resume = true;
      EXPECT_EQ(render(files, scene, settings).values, render(scene, settings).values) << driver;
    }
  }
}

// When the time limit ends a frame that can be resumed, the frame is not complete.
TEST_F(LibraryCheckpoints, FrameOutOfTimeIsNotComplete) {
  const Settings settings = small("bisection").set("spp", "1000000").set("time-limit", "0.1");
  const Scene scene = box(settings);
  EXPECT_TRUE(render(scene, settings).complete);
  EXPECT_FALSE(render(RenderFiles::at(path("frame")), scene, settings).complete);
  EXPECT_TRUE(fs::exists(path("frame")));
}

TEST_F(LibraryCheckpoints, BelongToOneFrame) {
  const Settings settings = small("bisection");
  Scene scene = box(settings);
  RenderFiles files = RenderFiles::at(path("a"));
  files.keep = true;
  render(files, scene, settings);
  ASSERT_TRUE(fs::exists(files.checkpoint));
  EXPECT_THROW(render(files, scene, Settings(settings).set("seed", "3")), UsageError)
      << "it would be replaced";
  files.resume = true;
  try {
    render(files, scene, Settings(settings).set("seed", "3"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("seed: 0 (now 3)"), std::string::npos) << error.what();
  }
  scene.edit(
      R"({"emberline_edits": 1, "lights": [{"kind": "material", "name": "light", "on": false}]})");
  EXPECT_THROW(render(files, scene, settings), InputError) << "edited since";
  scene.edit(R"({"emberline_edits": 1})");
  EXPECT_TRUE(render(files, scene, settings).complete);
  std::ofstream(path("text")) << "no checkpoint";
  EXPECT_THROW(render(RenderFiles::at(path("text")), scene, settings), UsageError);
  EXPECT_THROW(RenderFiles::at(""), UsageError);
  EXPECT_THROW(stored_frame(path("text")), InputError);
}

TEST_F(LibraryCheckpoints, AFinishedFrameGetsMore) {
  const Settings few = small("bucket").set("spp", "16"), many = small("bucket").set("spp", "24");
  const Scene scene = box(few);
  RenderFiles files = RenderFiles::at(path("frame"));
  files.keep = true;
  render(files, scene, few);
  const StoredFrame stored = stored_frame(files.checkpoint);
  EXPECT_EQ(stored.settings.get("spp"), "16");
  EXPECT_TRUE(fs::equivalent(stored.scene, EMBERLINE_SCENES "/cornell_box.glb"));
  const Scene again(stored.scene, stored.settings);
  EXPECT_THROW(extend(files.checkpoint, again, Settings().set("spp", "8")), UsageError);
  EXPECT_THROW(extend(files.checkpoint, again, Settings().set("spp", "24").set("seed", "9")),
               UsageError)
      << "another frame";
  const Picture more = extend(files.checkpoint, again, Settings().set("spp", "24"));
  EXPECT_EQ(more.values, render(scene, many).values);
  EXPECT_EQ(stored_frame(files.checkpoint).settings.get("spp"), "24");
  EXPECT_FALSE(fs::exists(files.checkpoint + ".next"));
}

TEST_F(LibraryCheckpoints, StudyUsesTheSettingsOfItsFrames) {
  const std::string scene = EMBERLINE_SCENES "/cornell_box.glb";
  const Settings frame = Settings().set("size", "8x8").set("max-depth", "2");
  StudyRequest request(path("study"));
  request.set("drivers", "bucket").set("spp", "1,2").set("seeds", "1").set("reference-spp", "8");
  const StudyTable table = study(scene, frame, request);
  EXPECT_TRUE(table.complete);
  EXPECT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(study(scene, frame, StudyRequest(request)).rows.size(), 2u) << "goes on";
  using Given = std::pair<std::string, std::string>;
  for (const auto& [name, text] :
       {Given("spp", "4"), Given("noise-threshold", "0.1"), Given("light-groups", "yes"),
        Given("denoise", "yes"), Given("aov", "N"), Given("variant", "dark")}) {
    try {
      study(scene, Settings(frame).set(name, text), request);
      FAIL() << name;
    } catch (const UsageError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(name + ": study does not accept"))
          << error.what();
    }
  }
  EXPECT_THROW(request.set("budgets", "1"), UsageError);
  EXPECT_THROW(request.set("seeds", "some"), UsageError);
  EXPECT_THROW(request.set("denoise", "perhaps"), UsageError);
  EXPECT_THROW(study(scene, frame, StudyRequest("")), UsageError);
}

TEST_F(LibraryCheckpoints, PartsBecomeTheWhole) {
  const Settings settings = small("bucket")
                                .set("bucket-size", "8")
                                .set("cryptomatte", "object")
                                .set("denoise", "yes")
                                .set("spp", "16");
  const Scene scene = box(settings);
  const Picture whole = render(scene, settings);
  std::vector<std::string> parts;
  for (const char* const part : {"1/2", "2/2"}) {
    parts.push_back(path("part" + std::string(1, part[0])));
    render(RenderFiles::at(parts.back()), scene, Settings(settings).set("part", part));
  }
  const Picture merged = merge(parts, {.parts = false});
  EXPECT_EQ(merged.channels, whole.channels);
  EXPECT_EQ(merged.values, whole.values);
  EXPECT_EQ(merged.samples, whole.samples);
  EXPECT_TRUE(merged.complete);
  EXPECT_EQ(stored_frame(parts[0]).mattes.at(0).ids, matte_names(scene, settings).at(0).ids);
  EXPECT_THROW(merge({parts[0]}), InputError);
  const Picture holes = merge({parts[0]}, {.allow_holes = true, .parts = true});
  EXPECT_FALSE(holes.complete);
  EXPECT_LT(holes.samples, whole.samples);
  EXPECT_EQ(std::ranges::count(holes.channels, "part"), 1);
  EXPECT_THROW(merge({}), UsageError);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(merge(parts, {}, {}, stop.get_token()), Stopped);
  const std::string file = path("merged.exr");
  write_picture(file, merge(parts));
  EXPECT_EQ(RenderedPicture(read_picture(file)).rec709(), RenderedPicture(whole).rec709());
}

// A checkpoint belongs to the files from which the scene was loaded. If one of them has changed
// since, the frame is refused.
TEST_F(LibraryCheckpoints, UseTheFilesThatWereLoaded) {
  const auto copy = [&](const std::string& name, const std::string& from) {
    fs::copy_file(EMBERLINE_SCENES "/" + from, path(name), fs::copy_options::overwrite_existing);
  };
  copy("box.glb", "cornell_box.glb");
  copy("sky.hdr", "dusk.hdr");
  std::ofstream(path("edits.json"))
      << R"({"emberline_edits": 1, "environment": {"file": "sky.hdr"}})";
  const Settings settings = small("bucket").set("edits", path("edits.json"));
  const RenderFiles files = RenderFiles::at(path("frame"));
  const auto refused = [&](const Scene& scene) {
    try {
      render(files, scene, settings);
      return false;
    } catch (const InputError& error) {
      return std::string(error.what()).find("have changed") != std::string::npos;
    }
  };
  for (const char* const name : {"box.glb", "sky.hdr", "edits.json"}) {
    Scene scene(path("box.glb"), settings);
    EXPECT_FALSE(refused(scene)) << name;
    fs::rename(path(name), path("old"));
    EXPECT_TRUE(refused(scene)) << name;
    fs::copy_file(path("old"), path(name));
    EXPECT_TRUE(refused(scene)) << name << ": it is another file";
    EXPECT_FALSE(fs::exists(files.checkpoint));
    EXPECT_TRUE(render(scene, settings).complete) << "it needs no files";
    scene.edit(R"({"emberline_edits": 1})");
    EXPECT_EQ(refused(scene), name == std::string("box.glb")) << name << ": without those edits";
    fs::remove(path("old"));
  }
  const Scene scene(path("box.glb"), settings);
  fs::last_write_time(path("box.glb"), fs::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_TRUE(refused(scene)) << "its time is another";
}

// Some tiles meet the threshold while a few of their pixels have seen no noise. Every pixel must
// get samples in each round all the same, and a saved tile must be readable.
TEST_F(LibraryCheckpoints, UnbiasedTilesAreFiniteAndCanBeRead) {
  const Settings settings = small("bucket")
                                .set("size", "64x64")
                                .set("max-depth", "16")
                                .set("bucket-size", "8")
                                .set("noise-threshold", "0.05")
                                .set("spp", "64")
                                .set("unbiased", "yes");
  const Scene scene = box(settings);
  RenderFiles files = RenderFiles::at(path("unbiased"));
  files.keep = true;
  const Picture picture = render(files, scene, settings);
  EXPECT_TRUE(std::ranges::all_of(picture.values, [](float v) { return std::isfinite(v); }));
  files.resume = true;
  std::vector<std::string> messages;
  set_log([&](Message, std::string_view text) { messages.emplace_back(text); });
  EXPECT_EQ(render(files, scene, settings).values, picture.values);
  for (const std::string& text : messages) {
    EXPECT_EQ(text.find("damaged"), std::string::npos) << text;
  }
}

// The settings and the edits file describe another pose than the scene has. The checkpoint records
// the scene's pose, so a scene that is loaded from the settings alone cannot resume it.
TEST_F(LibraryCheckpoints, AreOfTheScenesPose) {
  const std::string edits = path("edits.json");
  std::ofstream(edits) << R"({"emberline_edits": 1, "animation": {"time": 0.1}})";
  const std::string blade = EMBERLINE_SCENES "/moving_blade.glb";
  const Settings plain = small("bisection"), edited = small("bisection").set("edits", edits);
  RenderFiles files = RenderFiles::at(path("posed"));
  files.keep = true;
  {
    Scene posed(blade, edited);
    posed.edit(R"({"emberline_edits": 1})");
    render(files, posed, plain);
  }
  files.resume = true;
  EXPECT_THROW(render(files, Scene(blade, plain), plain), InputError);

  files = RenderFiles::at(path("rest"));
  files.keep = true;
  {
    Scene at_rest = Scene::animated(blade, edited);
    at_rest.pose(plain);
    render(files, at_rest, plain);
  }
  files.resume = true;
  EXPECT_THROW(render(files, Scene(blade, edited), plain), InputError);
  EXPECT_NO_THROW({
    Scene at_rest = Scene::animated(blade, edited);
    at_rest.pose(plain);
    render(files, at_rest, plain);
  });
}

}  // namespace
}  // namespace emberline::api
