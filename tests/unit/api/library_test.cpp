#include "renderer/api/emberline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>

namespace emberline::api {
namespace {

const std::string kScenes = EMBERLINE_SCENES "/";
const std::string kHalfLight =
    R"({"emberline_edits": 1, "lights": [{"kind": "material", "name": "light", "intensity": 0.5}]})";

Settings small(const std::string& driver = "bucket") {
  Settings settings;
  settings.set("driver", driver).set("size", "24x24").set("spp", "8").set("max-depth", "4");
  return settings;
}

double mean(const Picture& picture) {
  double sum = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) sum += picture.pixel(x, y)[1];
  }
  return sum / (picture.width * picture.height);
}

class Library : public ::testing::Test {
 protected:
  void SetUp() override {
    set_log([](Message, std::string_view) {});
  }
  void TearDown() override { set_log({}); }
};

TEST_F(Library, TheHeaderSaysItsVersion) {
  EXPECT_EQ(version(), std::to_string(EMBERLINE_VERSION_MAJOR) + "." +
                           std::to_string(EMBERLINE_VERSION_MINOR) + "." +
                           std::to_string(EMBERLINE_VERSION_PATCH));
}

TEST_F(Library, SettingsAreTheCommands) {
  Settings settings;
  EXPECT_EQ(settings.get("size"), "1280x720");
  EXPECT_EQ(settings.get("spp"), "");
  settings.set("spp", "12").set("transparent", "yes");
  const Settings copy = settings;
  settings.set("spp", "13");
  EXPECT_EQ(copy.get("spp"), "12");
  EXPECT_EQ(copy.get("transparent"), "yes");
  EXPECT_THROW(settings.set("spp", "0"), UsageError);
  EXPECT_THROW(settings.set("samples", "1"), UsageError);
  EXPECT_THROW(settings.get("samples"), UsageError);
  EXPECT_THROW(settings.read("/no/file.json"), InputError);
  EXPECT_EQ(settings.get("spp"), "13") << "as it was";
}

TEST_F(Library, RendersTheRequestedFrame) {
  const Settings settings = small().set("crop", "4,5,20,24").set("aov", "Z");
  const Scene scene(kScenes + "cornell_box.glb", settings);
  const Picture picture = render(scene, settings);
  EXPECT_EQ(picture.width, 16);
  EXPECT_EQ(picture.height, 19);
  EXPECT_EQ(picture.x, 4);
  EXPECT_EQ(picture.y, 5);
  EXPECT_EQ(picture.channels, (std::vector<std::string>{"R", "G", "B", "A", "samples", "Z"}));
  EXPECT_EQ(picture.samples, 8u * 16 * 19);
  EXPECT_TRUE(picture.complete);
  EXPECT_EQ(picture.pixel(3, 3)[4], 8.0f);
  EXPECT_GT(picture.pixel(3, 3)[5], 0.0f);
  EXPECT_EQ(scene.materials(), (std::vector<std::string>{"white", "red", "green", "light"}));
  EXPECT_EQ(scene.cameras(), std::vector<std::string>{"camera"});
}

TEST_F(Library, EditableValuesChangeNothing) {
  const Settings settings = small();
  Scene scene(kScenes + "cornell_box.glb", settings);
  EXPECT_TRUE(scene.lights().empty());
  EXPECT_EQ(scene.light_sources(), std::vector<std::string>{"light"});
  EXPECT_FALSE(scene.nodes().empty());
  const Picture whole = render(scene, settings);
  scene.edit(scene.editable());
  EXPECT_EQ(render(scene, settings).values, whole.values);
}

// Light is linear: halving the only lamp halves every pixel exactly.
TEST_F(Library, EditsMatchTheCommand) {
  const Settings settings = small();
  Scene scene(kScenes + "cornell_box.glb", settings);
  const Picture whole = render(scene, settings);
  scene.edit(kHalfLight);
  const Picture half = render(scene, settings);
  EXPECT_GT(mean(whole), 0.01);
  for (int y = 0; y < whole.height; ++y) {
    for (int x = 0; x < whole.width; ++x) {
      for (int c = 0; c < 3; ++c) ASSERT_EQ(2 * half.pixel(x, y)[c], whole.pixel(x, y)[c]);
    }
  }
  EXPECT_THROW(scene.edit("{}"), InputError);
  EXPECT_THROW(
      scene.edit(R"({"emberline_edits": 1, "lights": [{"kind": "material", "name": "x"}]})"),
      InputError);
  EXPECT_EQ(render(scene, settings).values, half.values) << "as it was";
  scene.edit(R"({"emberline_edits": 1})");
  EXPECT_EQ(render(scene, settings).values, whole.values);
}

TEST_F(Library, AnEnvironmentOfTexels) {
  const Settings settings = small().set("look-from", "0,1,6").set("look-at", "0,1,0");
  Scene scene(kScenes + "cornell_box.glb", settings);
  const Picture whole = render(scene, settings);
  std::vector<float> sky(3 * 8 * 4, 1.0f);
  scene.edit(R"({"emberline_edits": 1})", {sky.data(), 8, 4});
  EXPECT_GT(mean(render(scene, settings)), mean(whole) + 0.1);
  sky[5] = -1.0f;
  EXPECT_THROW(scene.edit(R"({"emberline_edits": 1})", {sky.data(), 8, 4}), UsageError);
  EXPECT_THROW(scene.edit(R"({"emberline_edits": 1})", {sky.data(), 0, 4}), UsageError);
  scene.edit(R"({"emberline_edits": 1})");
  EXPECT_EQ(render(scene, settings).values, whole.values);
}

TEST_F(Library, TwoScenesAndTwoFramesAtOnce) {
  const Settings settings = small("adaptive");
  const Scene box(kScenes + "cornell_box.glb", settings);
  const Scene spheres(kScenes + "spheres.glb", settings);
  const Picture alone_box = render(box, settings), alone_spheres = render(spheres, settings);
  const Scene* const scenes[] = {&box, &spheres, &box, &spheres};
  Picture pictures[4];
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&, i] {
        Resources resources;
        resources.threads = 1 + i % 3;
        pictures[i] = render(*scenes[i], settings, resources);
      });
    }
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(pictures[i].values, (i % 2 ? alone_spheres : alone_box).values) << i;
  }
  EXPECT_TRUE(alone_box.error_estimate.has_value());
}

TEST_F(Library, IsWatchedAndStopped) {
  const Settings settings = small("bisection").set("spp", "4096").set("size", "64x64");
  const Scene scene(kScenes + "cornell_box.glb", settings);
  std::stop_source stop;
  int pictures = 0;
  uint64_t samples = 0;
  const Picture picture = render(scene, settings, {}, stop.get_token(), [&](const Progress& now) {
    ++pictures;
    EXPECT_GT(now.samples, samples);
    samples = now.samples;
    ASSERT_NE(now.rgba, nullptr);
    EXPECT_TRUE(std::isfinite(now.rgba[0]));
    if (samples >= 64 * 64) stop.request_stop();
  });
  EXPECT_GT(pictures, 1);
  EXPECT_FALSE(picture.complete);
  EXPECT_GE(picture.samples, 64u * 64);
  EXPECT_LT(picture.samples, 64u * 64 * 4096);
  struct Mine {};
  EXPECT_THROW(render(scene, settings, {}, {}, [](const Progress&) { throw Mine(); }), Mine);
}

TEST_F(Library, AbandonedRenderReturnsNothing) {
  const Settings settings = small("adaptive").set("spp", "16777216");
  const Scene scene(kScenes + "cornell_box.glb", settings);
  std::stop_source give_up;
  EXPECT_THROW(render(
                   scene, settings, {}, {}, [&](const Progress&) { give_up.request_stop(); },
                   give_up.get_token()),
               Stopped);
}

TEST_F(Library, BucketsAreWatchedTileByTile) {
  const Settings settings = small().set("bucket-size", "8");
  const Scene scene(kScenes + "cornell_box.glb", settings);
  std::vector<uint64_t> samples;
  const Picture picture = render(scene, settings, {}, {}, [&](const Progress& now) {
    samples.push_back(now.samples);
    EXPECT_EQ(now.rgba, nullptr);
    EXPECT_EQ(now.width, 24);
  });
  EXPECT_EQ(samples.size(), 9u);
  EXPECT_TRUE(std::is_sorted(samples.begin(), samples.end()));
  EXPECT_EQ(samples.back(), picture.samples);
  EXPECT_EQ(picture.frame_width, 24);
  struct Mine {};
  EXPECT_THROW(render(scene, settings, {}, {}, [](const Progress&) { throw Mine(); }), Mine);
}

TEST_F(Library, ListsTheSettings) {
  bool driver = false, environment = false;
  for (const Settings::Help& row : Settings::help()) {
    Settings().get(row.name);
    if (row.name == "driver")
      driver = !row.of_scene && row.values.find("adaptive") != row.values.npos;
    if (row.name == "env") environment = row.of_scene && row.type == "FILE";
  }
  EXPECT_TRUE(driver);
  EXPECT_TRUE(environment);
}

TEST_F(Library, TheTimeLimitEndsAFrame) {
  const Settings settings = small("bisection").set("spp", "16777216").set("time-limit", "0.05");
  const Scene scene(kScenes + "cornell_box.glb", settings);
  const Picture picture = render(scene, settings);
  EXPECT_TRUE(picture.complete) << "is what was asked for";
  EXPECT_LT(picture.samples, 24u * 24 * 16777216);
}

TEST_F(Library, BucketsThatAreWorkedOnCountTowardsTheMemory) {
  Resources one_thread;
  one_thread.threads = 1;
  one_thread.memory_bytes = 48 << 20;
  const Scene scene(kScenes + "cornell_box.glb", {}, one_thread);
  Settings settings;
  settings.set("size", "1024x1024").set("spp", "1").set("max-depth", "1").set("driver", "bucket");
  EXPECT_TRUE(render(scene, settings.set("bucket-size", "64"), one_thread).complete);
  EXPECT_THROW(render(scene, settings.set("bucket-size", "1024"), one_thread), InputError);
}

TEST_F(Library, ErrorsNameTheProblem) {
  EXPECT_THROW(Scene("/no/scene.glb"), InputError);
  Resources little;
  little.memory_bytes = 1000;
  EXPECT_THROW(Scene(kScenes + "cornell_box.glb", {}, little), InputError);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(Scene(kScenes + "cornell_box.glb", {}, {}, stop.get_token()), Stopped);
  const Scene scene(kScenes + "cornell_box.glb");
  EXPECT_THROW(render(scene, Settings().set("backfaces", "show")), UsageError);
  EXPECT_THROW(render(scene, Settings().set("integrator", "uv")), UsageError);
  EXPECT_THROW(render(scene, Settings().set("cryptomatte", "object")), UsageError);
  EXPECT_THROW(render(scene, Settings().set("working-space", "acescg")), UsageError);
  EXPECT_THROW(render(scene, Settings().set("crop", "0,0,9999,1")), UsageError);
  EXPECT_THROW(render(scene, Settings().set("camera", "none")), UsageError);
  try {
    Settings().set("sampler", "sobel");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'sobol'"), std::string::npos);
  }
}

// The resources have the same ranges as the command's options.
TEST_F(Library, RejectsInvalidResources) {
  const std::string file = kScenes + "cornell_box.glb";
  const Scene scene(file);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const Resources& wrong :
       {Resources{.threads = -1}, Resources{.threads = 4097}, Resources{.memory_bytes = 0},
        Resources{.load_timeout_s = 0.0}, Resources{.load_timeout_s = -1.0},
        Resources{.load_timeout_s = 2e9}, Resources{.load_timeout_s = kNaN}}) {
    EXPECT_THROW(Scene(file, {}, wrong), UsageError);
    EXPECT_THROW(render(scene, {}, wrong), UsageError);
    EXPECT_THROW(read_picture(file, wrong), UsageError);
  }
}

TEST_F(Library, MessagesGoToTheHandler) {
  std::mutex mutex;
  std::string all;
  set_log([&](Message kind, std::string_view text) {
    const std::lock_guard lock(mutex);
    all += std::string(kind == Message::kWarning ? "warning: " : "") + std::string(text) + "\n";
  });
  testing::internal::CaptureStderr();
  const Settings settings = small();
  for (int i = 0; i < 2; ++i) {
    all.clear();
    const Scene scene(kScenes + "checker_plane.glb", settings);
    EXPECT_NE(all.find("warning: the scene has no light"), std::string::npos) << i << ": " << all;
  }
  set_log({});
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace emberline::api
