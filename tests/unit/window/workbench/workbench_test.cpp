// Tests the window's logic without a window: edits, wipes and files, with a small Cornell box.
#include "renderer/window/workbench/workbench.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "io/json/edits_file.h"
#include "renderer/window/panels/edit_entries.h"
#include "support/edits.h"
#include "support/sanitized.h"
#include "unit/output_folder.h"

namespace emberline {
namespace {

class WorkbenchTest : public OutputFolder {
 protected:
  static std::string box() { return std::string(EMBERLINE_SCENES) + "/cornell_box.glb"; }

  static ViewOptions options(const std::string& scene) {
    ViewOptions result;
    result.render.scene = scene;
    result.render.driver = "bisection";
    result.render.width = 48;
    result.render.height = 32;
    result.render.spp = 1;
    result.render.threads = 1;
    return result;
  }

  // Updates the workbench, as the window's loop does, until done() is true. Returns false after two
  // minutes.
  static bool wait(Workbench& bench, const std::function<bool()>& done) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::seconds(int(120 * test::kSanitizerSlowdown));
    while (!done()) {
      if (Clock::now() >= end) return false;
      bench.update();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }
  static bool wait_for_picture(Workbench& bench) {
    return wait(bench, [&] { return bench.picture() && bench.picture()->filled; });
  }

  static LightEdit with_intensity(const Workbench& bench, float intensity) {
    const ListedScene& scene = *bench.session.scene();
    const ListedLight listed = list_lights(scene.outline, bench.session.edits()).at(0);
    LightEdit edit = light_edit(bench.session.edits(), scene.outline, listed.kind, listed.index);
    edit.intensity = intensity;
    return edit;
  }

  WindowState state_;
};

TEST_F(WorkbenchTest, ChangesOfOneGestureAreOneStepOfUndo) {
  Workbench bench(
      options(box()), state_, [] {}, [](const std::string&) {});
  ASSERT_TRUE(wait_for_picture(bench));
  const SceneEdits before = bench.session.edits();
  bench.edits.change(with_intensity(bench, 2.0f), "light");
  bench.edits.change(with_intensity(bench, 3.0f), "light");
  bench.update_gesture(false);
  const SceneEdits first = bench.session.edits();
  bench.edits.change(with_intensity(bench, 4.0f), "light");
  EXPECT_TRUE(bench.edits.has_unsaved_edits());
  bench.act(Action::kUndo);
  EXPECT_EQ(bench.session.edits(), first);
  bench.act(Action::kUndo);
  EXPECT_EQ(bench.session.edits(), before);
  EXPECT_FALSE(bench.edits.can_undo());
  EXPECT_FALSE(bench.edits.has_unsaved_edits());
  bench.act(Action::kRedo);
  EXPECT_EQ(bench.session.edits(), first);
}

TEST_F(WorkbenchTest, RefusedEditChangesNothingAndAddsNoUndoStep) {
  Workbench bench(
      options(box()), state_, [] {}, [](const std::string&) {});
  ASSERT_TRUE(wait_for_picture(bench));
  const SceneEdits before = bench.session.edits();
  SceneEdits bad = before;
  test::material(bad, 12345).roughness = 0.5f;
  bench.edits.change(bad, "material 12345");
  EXPECT_EQ(bench.session.edits(), before);
  EXPECT_FALSE(bench.edits.can_undo());
  ASSERT_FALSE(bench.messages.messages().empty());
  EXPECT_EQ(bench.messages.messages().back().level, Message::Level::kError);
}

TEST_F(WorkbenchTest, ThereIsOneWipeAtATime) {
  Workbench bench(
      options(box()), state_, [] {}, [](const std::string&) {});
  ASSERT_TRUE(wait_for_picture(bench));
  const auto include_raw = [&] { return bench.session.settings().include_raw; };
  bench.act(Action::kWipe);
  EXPECT_EQ(bench.comparison.wipe(), Wipe::kNone) << "there is no B yet";
  bench.act(Action::kStoreSnapshot);
  bench.act(Action::kWipe);
  EXPECT_EQ(bench.comparison.wipe(), Wipe::kStored);
  bench.act(Action::kWipeRaw);
  EXPECT_EQ(bench.comparison.wipe(), Wipe::kRaw);
  EXPECT_TRUE(include_raw());
  bench.act(Action::kWipe);
  EXPECT_EQ(bench.comparison.wipe(), Wipe::kStored);
  EXPECT_FALSE(include_raw());
  bench.act(Action::kWipeRaw);
  bench.act(Action::kDenoise);
  EXPECT_EQ(bench.comparison.wipe(), Wipe::kNone);
  EXPECT_FALSE(include_raw());
  bench.act(Action::kWipeRaw);
  EXPECT_EQ(bench.comparison.wipe(), Wipe::kNone) << "the picture is raw on both sides";
}

TEST_F(WorkbenchTest, ReloadingKeepsTheEditsAndNotTheirHistory) {
  Workbench bench(
      options(box()), state_, [] {}, [](const std::string&) {});
  ASSERT_TRUE(wait_for_picture(bench));
  bench.edits.change(with_intensity(bench, 2.0f), "light");
  bench.act(Action::kStoreBookmark, 3);
  const SceneEdits edits = bench.session.edits();
  const auto before = bench.session.scene();
  bench.act(Action::kReload);
  ASSERT_TRUE(wait(bench, [&] { return bench.session.scene() != before; }));
  EXPECT_EQ(bench.session.edits(), edits);
  EXPECT_TRUE(bench.edits.has_unsaved_edits());
  EXPECT_FALSE(bench.edits.can_undo());
  EXPECT_TRUE(bench.navigator.bookmarks()[2]);
  bench.files.open(box());
  const auto reloaded = bench.session.scene();
  ASSERT_TRUE(wait(bench, [&] { return bench.session.scene() != reloaded; }));
  EXPECT_EQ(bench.session.edits(), SceneEdits());
  EXPECT_FALSE(bench.edits.has_unsaved_edits());
  EXPECT_FALSE(bench.navigator.bookmarks()[2]);
}

// Edits from a file on the command line belong to the scene on the command line.
TEST_F(WorkbenchTest, EditsOfAnotherSceneDoNotReplaceTheFileThatWasGiven) {
  ViewOptions given = options(path("missing.glb"));
  given.render.edits = path("given.edits.json");
  write_edits(given.render.edits, SceneEdits());
  const auto written = std::filesystem::last_write_time(given.render.edits);
  std::filesystem::copy_file(box(), path("other.glb"));
  Workbench bench(
      given, state_, [] {}, [](const std::string&) {});
  ASSERT_TRUE(wait(bench, [&] { return bench.load_status().state == LoadStatus::State::kFailed; }));
  bench.files.open(path("other.glb"));
  ASSERT_TRUE(wait_for_picture(bench));
  bench.edits.change(with_intensity(bench, 2.0f), "light");
  bench.act(Action::kSaveEdits);
  ASSERT_TRUE(wait(bench, [&] { return !bench.edits.has_unsaved_edits(); }));
  EXPECT_TRUE(std::filesystem::exists(path("other.edits.json")));
  EXPECT_EQ(std::filesystem::last_write_time(given.render.edits), written);
}

}  // namespace
}  // namespace emberline
