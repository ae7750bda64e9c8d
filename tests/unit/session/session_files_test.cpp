// Tests the files that a session writes in the background.
#include <gtest/gtest.h>

#include "renderer/core/errors.h"
#include "renderer/film/filter.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionFilesTest : public SessionFixture {
 protected:
  // Expects a session to show the command's picture, and to save it with all channels.
  void expect_equals_render(const ViewSettings& view, RenderOptions options) {
    SessionOwner owner(view);
    owner.open(scene("cornell_box"));
    ASSERT_TRUE(finishes(owner));
    owner.session.save(path("saved.exr")).get();
    options.scene = scene("cornell_box");
    expect_same_bits(owner.session.picture()->rgba, rendered(options), "as shown");
    const FloatImage saved = read_float_image(path("saved.exr"));
    const FloatImage expected = read_float_image(path("rendered.exr"));
    EXPECT_EQ(saved.channel_names, expected.channel_names);
    expect_same_bits(saved.values, expected.values, "saved");
  }
};

TEST_F(SessionFilesTest, SavesThePictureWithItsChannels) {
  ViewSettings view = settings("bisection", 8);
  view.render.aovs = "variance,N,stop";
  RenderOptions options = view.render;
  options.driver = "bucket";
  expect_equals_render(view, options);
}

// The variance of adaptive frames is saved, also with the bucket driver.
TEST_F(SessionFilesTest, SavesTheVarianceOfAdaptiveFrames) {
  ViewSettings adaptive = settings("adaptive", 40), bucket = settings("bucket");
  bucket.render.noise_threshold = 0.05f;
  bucket.render.max_spp = 64;
  for (ViewSettings& view : {std::ref(adaptive), std::ref(bucket)}) {
    SCOPED_TRACE(view.render.driver);
    view.render.aovs = "variance";
    expect_equals_render(view, view.render);
  }
}

TEST_F(SessionFilesTest, NothingThatIsOpenIsReplaced) {
  const auto copy = [&](const std::string& from, const char* name) {
    std::filesystem::copy_file(from, path(name));
    return path(name);
  };
  ViewSettings view = settings("bisection", 1);
  view.render.environment = copy(std::string(EMBERLINE_SCENES) + "/dusk.hdr", "sky.hdr");
  const std::string scene = copy(this->scene("cornell_box"), "box.glb");
  const std::string edited = copy(view.render.environment, "edited.hdr");
  SessionOwner owner(view);
  owner.open(scene);
  ASSERT_TRUE(finishes(owner));
  SceneEdits edits = owner.session.edits();
  edits.environment.file = edited;
  owner.session.set_edits(edits);
  for (const std::string& input : {scene, view.render.environment, edited}) {
    SCOPED_TRACE(input);
    const auto size = std::filesystem::file_size(input);
    for (const char* name : {"saved.png", "saved.exr"}) {
      std::filesystem::create_hard_link(input, path(name));
      EXPECT_THROW(owner.session.save(path(name)).get(), UsageError);
      EXPECT_THROW(owner.session.save_heatmap(path(name), ViewOverlay::kSamples).get(), UsageError);
      std::filesystem::remove(path(name));
    }
    EXPECT_THROW(owner.session.save_edits(input).get(), UsageError);
    EXPECT_EQ(std::filesystem::file_size(input), size);
  }
  owner.session.save_edits(path("look.json")).get();
}

TEST_F(SessionFilesTest, SavesPicturesAsTheCommandDoes) {
  ViewSettings view = settings("bisection", 4);
  view.display.exposure = 1.0f;
  SessionOwner owner(view);
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  RenderOptions options = view.render;
  options.scene = scene("cornell_box");
  options.display = view.display;
  for (const char* name : {"a.png", "a.jpg"}) {
    owner.session.save(path(name)).get();
    options.outputs = {path("command-" + std::string(name))};
    ASSERT_EQ(run_render(options), 0);
    EXPECT_EQ(read_text(path(name)), read_text(options.outputs.front())) << name;
  }
}

TEST_F(SessionFilesTest, SavesHeatmapsAndTheirValues) {
  SessionOwner owner(settings("adaptive", 16));
  owner.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(owner));
  owner.session.save_heatmap(path("samples.png"), ViewOverlay::kSamples).get();
  owner.session.save_heatmap(path("samples.exr"), ViewOverlay::kSamples).get();
  EXPECT_GT(read_text(path("samples.png")).size(), 100u);
  const FloatImage values = read_float_image(path("samples.exr"));
  double sum = 0;
  for (const float value : values.values) sum += double(value);
  EXPECT_EQ(sum, double(owner.session.picture()->samples));
  expect_error<RenderError>(
      [&] { owner.session.save_heatmap(path("time.png"), ViewOverlay::kTime).get(); }, "time");
  EXPECT_THROW(owner.session.save_heatmap(path("tree.png"), ViewOverlay::kTree), UsageError);
}

TEST_F(SessionFilesTest, ReportsUnwritableFiles) {
  SessionOwner owner(settings("bisection", 1));
  EXPECT_THROW(owner.session.save(path("early.exr")).get(), RenderError);
  owner.open(scene("cornell_box"));
  EXPECT_THROW(owner.session.save(path("no/such/folder.exr")).get(), RenderError);
  EXPECT_THROW(owner.session.save(path("picture.bmp")).get(), UsageError);
  EXPECT_THROW(owner.session.save_edits(path("no/such/folder.json")).get(), RenderError);
  EXPECT_TRUE(contents().empty());
}

TEST_F(SessionFilesTest, WritesFilesEvenIfTheCallerDoesNotWait) {
  {
    SessionOwner owner(settings("live"));
    owner.open(scene("cornell_box"));
    for (int i = 0; i < 3; ++i) owner.session.save(path(std::to_string(i) + ".png"));
    owner.session.save_edits(path("edits.json"));
    owner.wait(30, [&] { return contents().size() == 4; });
  }
  EXPECT_EQ(contents(), (std::vector<std::string>{"0.png", "1.png", "2.png", "edits.json"}));
}

}  // namespace
}  // namespace emberline
