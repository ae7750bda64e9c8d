// Tests time as an edit: another pose of an open scene has the bits of `render --time`.
#include <gtest/gtest.h>

#include "renderer/core/errors.h"
#include "support/animated_stage.h"
#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

constexpr const char* kAll = "all that moves";

class SessionTimeTest : public SessionFixture {
 protected:
  void SetUp() override {
    SessionFixture::SetUp();
    file_ = test::AnimatedStage().gltf.write_glb(path("stage.glb"));
  }

  RenderOptions options(std::optional<double> time, const std::string& animation = kAll) const {
    RenderOptions result = settings("bucket", 4).render;
    result.scene = file_;
    if (time) result.animation = animation;
    result.time = time;
    return result;
  }
  static SceneEdits at(double time, const std::string& animation = kAll) {
    SceneEdits edits;
    edits.animation.name = animation;
    edits.animation.time = time;
    return edits;
  }
  void expect_shown(SessionOwner& owner, const RenderOptions& expected, const std::string& what) {
    ASSERT_TRUE(finishes(owner)) << what;
    expect_same_bits(owner.session.picture()->rgba, rendered(expected), what);
  }

  std::string file_;
};

TEST_F(SessionTimeTest, APoseHasTheBitsOfTheCommand) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(file_);
  expect_shown(owner, options(std::nullopt), "at rest");
  for (const double time : {0.3, 1.2, 0.3}) {
    owner.session.set_edits(at(time));
    expect_shown(owner, options(time), std::to_string(time));
  }
  SceneEdits edits = at(0.8);
  edits.animation.fps = 12;
  edits.animation.shutter_open = 0.0;
  edits.animation.shutter_close = 0.5;
  owner.session.set_edits(edits);
  RenderOptions open = options(0.8);
  open.fps = 12;
  open.shutter = Shutter{0.0, 0.5};
  expect_shown(owner, open, "open");
  owner.session.set_edits(at(1.1, "camera"));
  expect_shown(owner, options(1.1, "camera"), "another animation");
  owner.session.set_edits({});
  expect_shown(owner, options(std::nullopt), "at rest again");
}

TEST_F(SessionTimeTest, TheOptionsTimeIsAnEditOfTheScene) {
  ViewSettings view = settings("bisection", 4);
  view.render.animation = kAll;
  view.render.frame = 15;
  view.render.fps = 12;
  SessionOwner owner(view);
  owner.open(file_);
  EXPECT_EQ(owner.session.edits().animation.name, kAll);
  EXPECT_EQ(owner.session.edits().animation.time, 1.25);
  expect_shown(owner, options(1.25), "as opened");
  owner.session.set_edits(at(0.5));
  expect_shown(owner, options(0.5), "as edited");
}

TEST_F(SessionTimeTest, SavedTimesGiveTheCommandTheSameBits) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(file_);
  SceneEdits edits = at(0.9);
  edits.animation.fps = 10;
  edits.animation.shutter_open = -0.5;
  edits.animation.shutter_close = 1.0;
  test::material(edits, 0).base_color = Rgb(0.2f, 0.6f, 0.3f);
  owner.session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  const std::vector<float> shown = owner.session.picture()->rgba;
  owner.session.save_edits(path("look.json")).get();
  RenderOptions saved = options(std::nullopt);
  saved.edits = path("look.json");
  expect_same_bits(shown, rendered(saved), "saved edits");
  SessionOwner other(settings("bisection", 4));
  other.open(file_, path("look.json"));
  EXPECT_EQ(other.session.edits(), edits);
  expect_shown(other, saved, "opened edits");
  // The times on the command line take precedence over those in the edits file.
  SceneEdits as_well = edits;
  as_well.animation.time = 0.2;
  as_well.animation.fps.reset();
  as_well.animation.shutter_open = as_well.animation.shutter_close = std::nullopt;
  owner.session.set_edits(as_well);
  ASSERT_TRUE(finishes(owner));
  RenderOptions timed = saved;
  timed.animation = kAll;
  timed.time = 0.2;
  timed.shutter = Shutter{0.0, 0.0};
  expect_same_bits(owner.session.picture()->rgba, rendered(timed), "the command line's time");
}

// As in playback, later times replace earlier ones, and the last one is shown.
TEST_F(SessionTimeTest, TheLatestTimeCounts) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(file_);
  for (int i = 0; i <= 200; ++i) owner.session.set_edits(at(0.01 * i));
  expect_shown(owner, options(2.0), "the last");
}

TEST_F(SessionTimeTest, WithLightGroupsToo) {
  ViewSettings view = settings("bisection", 4);
  view.light_groups = true;
  SessionOwner owner(view);
  owner.open(file_);
  SceneEdits edits = at(1.3);
  owner.session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  const std::vector<float> without = owner.session.picture()->rgba;
  edits.lights.emplace_back().target.index = 0;
  edits.lights.back().intensity = 3.0f;
  owner.session.set_edits(edits);
  ASSERT_TRUE(finishes(owner));
  EXPECT_NE(owner.session.picture()->rgba, without);
  expect_same_bits(without, rendered(options(1.3)), "posed");
}

TEST_F(SessionTimeTest, RefusedTimesChangeNothing) {
  SessionOwner owner(settings("bisection", 4));
  owner.open(file_);
  owner.session.set_edits(at(0.4));
  EXPECT_THROW(owner.session.set_edits(at(0.4, "nothing")), InputError);
  EXPECT_EQ(owner.session.edits(), at(0.4));
  expect_shown(owner, options(0.4), "as before");
}

}  // namespace
}  // namespace emberline
