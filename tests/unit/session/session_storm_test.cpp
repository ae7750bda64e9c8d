// Puts a session under stress: hundreds of edits, resizing, scenes that are opened before others
// are loaded, and closing at any moment. ThreadSanitizer runs this file, too.
#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "unit/session_fixture.h"

namespace emberline {
namespace {

using test::SessionOwner;

class SessionStormTest : public SessionFixture {};

void pass_ms(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

TEST_F(SessionStormTest, FiveHundredEditsInASecond) {
  SessionOwner owner(settings("live", 4));
  owner.open(scene("cornell_box"));
  RenderSession& session = owner.session;
  const uint64_t first = session.edit();
  std::set<uint64_t> shown;
  for (int i = 0; i < 500; ++i) {
    session.set_edits(some_edits(0.001f * float(i)));
    pass_ms(2);
    shown.insert(session.picture()->edit);
  }
  EXPECT_EQ(session.edit(), first + 500);
  EXPECT_GT(shown.size(), 5u) << "pictures come during the storm";
  ASSERT_TRUE(finishes(owner));
  EXPECT_EQ(session.picture()->edit, session.edit());
  // Only the newest edit counts, whatever came before.
  SessionOwner calm(settings("live", 4));
  calm.open(scene("cornell_box"));
  calm.session.set_edits(session.edits());
  ASSERT_TRUE(finishes(calm));
  expect_same_bits(session.picture()->rgba, calm.session.picture()->rgba, "after the storm");
}

TEST_F(SessionStormTest, AWindowThatChangesItsSize) {
  SessionOwner owner(settings("live", 4));
  owner.open(scene("cornell_box"));
  ViewSettings view = owner.session.settings();
  for (int i = 0; i < 120; ++i) {
    view.render.width = 16 + 7 * i % 61;
    view.render.height = 16 + 11 * i % 47;
    owner.session.set_settings(view);
    const auto picture = owner.session.picture();
    ASSERT_EQ(picture->rgba.size(), 4 * size_t(picture->width) * size_t(picture->height));
    owner.session.inspect(picture->width - 1, picture->height - 1);
    pass_ms(i % 4);
  }
  ASSERT_TRUE(finishes(owner));
  EXPECT_EQ(owner.session.picture()->width, view.render.width);
  EXPECT_EQ(owner.session.picture()->height, view.render.height);
}

TEST_F(SessionStormTest, EverythingAtOnce) {
  SessionOwner owner(settings("live", 8));
  owner.open(scene("cornell_box"));
  RenderSession& session = owner.session;
  constexpr const char* kDrivers[] = {"live", "bucket", "bisection", "adaptive"};
  for (int i = 0; i < 200; ++i) {
    ViewSettings view = session.settings();
    switch (i % 8) {
      case 0:
        view.render.driver = kDrivers[i / 8 % 4];
        break;
      case 1:
        session.set_edits(some_edits(0.01f * float(i)));
        break;
      case 2:
        view.display.exposure = 0.1f * float(i % 20);
        break;
      case 3:
        view.overlay = ViewOverlay(i / 8 % 7);
        break;
      case 4:
        session.inspect(i % 48, i % 32);
        break;
      case 5:
        view.paused = !view.paused;
        break;
      case 6:
        view.region = i % 3 ? std::optional(Rect{i % 40, 0, 48, 16}) : std::nullopt;
        break;
      default:
        session.save(path(std::to_string(i) + ".png"));
    }
    session.set_settings(view);
    session.load_status();
    session.problem();
    pass_ms(i % 5);
  }
  ViewSettings view = settings("live", 8);
  session.set_settings(view);
  session.set_edits({});
  ASSERT_TRUE(finishes(owner));
  EXPECT_EQ(session.problem(), "");
  SessionOwner calm(view);
  calm.open(scene("cornell_box"));
  ASSERT_TRUE(finishes(calm));
  expect_same_bits(session.picture()->rgba, calm.session.picture()->rgba, "after all of it");
}

TEST_F(SessionStormTest, ASceneThatFailsLeavesTheOldOne) {
  SessionOwner owner(settings("live", 4));
  owner.open(scene("cornell_box"));
  const auto before = owner.session.scene();
  owner.session.set_edits(some_edits());
  owner.session.open(path("none.glb"));
  ASSERT_TRUE(owner.wait(
      60, [&] { return owner.session.load_status().state == LoadStatus::State::kFailed; }));
  EXPECT_NE(owner.session.load_status().error.find("none.glb"), std::string::npos);
  EXPECT_EQ(owner.session.scene(), before);
  EXPECT_EQ(owner.session.edits(), some_edits());
  ASSERT_TRUE(finishes(owner));
  // If the edits are missing or belong to another scene, the scene that is opened with them fails.
  owner.session.open(scene("spheres"), path("none.json"));
  ASSERT_TRUE(owner.wait(60, [&] {
    return owner.session.load_status().error.find("none.json") != std::string::npos;
  }));
  EXPECT_EQ(owner.session.scene(), before);
}

TEST_F(SessionStormTest, SecondSceneReplacesTheFirst) {
  SessionOwner owner(settings("live", 4));
  owner.open(scene("cornell_box"));
  owner.session.set_edits(some_edits());
  owner.session.open(scene("spheres"));
  // The first scene stays until the second is loaded.
  while (owner.session.load_status().state == LoadStatus::State::kLoading) {
    ASSERT_EQ(owner.session.edits(), some_edits());
    pass_ms(1);
  }
  EXPECT_EQ(owner.session.edits(), SceneEdits{});
  ASSERT_TRUE(finishes(owner));
  SessionOwner other(settings("live", 4));
  other.open(scene("spheres"));
  ASSERT_TRUE(finishes(other));
  expect_same_bits(owner.session.picture()->rgba, other.session.picture()->rgba, "the second");
}

TEST_F(SessionStormTest, OnlyTheNewestOfManyScenesCounts) {
  SessionOwner owner(settings("live", 2));
  for (int i = 0; i < 6; ++i) {
    owner.session.open(scene(i % 2 ? "cornell_box" : "teapot"));
    pass_ms(3 * i);
    owner.session.load_status();
  }
  owner.session.open(scene("spheres"));
  ASSERT_TRUE(owner.wait(
      120, [&] { return owner.session.load_status().state == LoadStatus::State::kReady; }));
  EXPECT_EQ(owner.session.load_status().path, scene("spheres"));
  EXPECT_NE(owner.session.scene()->outline.file.find("spheres"), std::string::npos);
  ASSERT_TRUE(finishes(owner));
}

TEST_F(SessionStormTest, ACancelledSceneNeverComes) {
  SessionOwner owner(settings("live", 2));
  owner.open(scene("cornell_box"));
  const auto before = owner.session.scene();
  owner.session.open(scene("glass_metal"));
  owner.session.cancel_load();
  EXPECT_EQ(owner.session.load_status().state, LoadStatus::State::kCancelled);
  pass_ms(300);
  EXPECT_EQ(owner.session.load_status().state, LoadStatus::State::kCancelled);
  EXPECT_EQ(owner.session.scene(), before);
  owner.session.cancel_load();  // without a load
  ASSERT_TRUE(finishes(owner));
}

TEST_F(SessionStormTest, ClosesAtAnyMoment) {
  for (int i = 0; i < 20; ++i) {
    SessionOwner owner(settings(i % 3 ? "live" : "bucket"));
    owner.session.open(scene(i % 2 ? "teapot" : "cornell_box"));
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(7 * i);
    owner.wait(0.007 * i, [&] {
      owner.session.load_status();
      return std::chrono::steady_clock::now() >= until;
    });
    if (i % 5 == 4) {
      ViewSettings view = owner.session.settings();
      view.paused = true;
      owner.session.set_settings(view);
      owner.session.set_edits(some_edits());
      owner.session.save(path("last.exr"));
    }
  }
}

}  // namespace
}  // namespace emberline
