// Implements the actions.
#include <array>
#include <numbers>

#include "renderer/session/overlay_picture.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {
namespace {

constexpr float kExposureStep = 0.25f;  // stops
constexpr double kZoomStep = std::numbers::sqrt2;

void flip(bool& flag) { flag = !flag; }

void zoom_to_one_or_fit(Workbench& bench) {
  if (bench.placement.fitted()) return bench.placement.zoom_to(1.0);
  bench.placement.fit();
}

void undo(Workbench& bench) {
  bench.player.stop();
  bench.edits.undo();
}

void redo(Workbench& bench) {
  bench.player.stop();
  bench.edits.redo();
}

void clear_region(Workbench& bench) {
  bench.edits.set_solo(std::nullopt);
  if (!bench.session.settings().region) return;
  bench.settings.change_with([](ViewSettings& s) { s.region.reset(); });
}

void toggle_pause(Workbench& bench) {
  bench.settings.change_with([](ViewSettings& s) { s.paused = !s.paused; });
}

// Restarts the frame by changing to the next seed.
void restart(Workbench& bench) {
  bench.settings.change_with([](ViewSettings& s) { s.render.seed += 1; });
}

void add_exposure(Workbench& bench, float stops) {
  bench.settings.change_with([&](ViewSettings& s) { s.display.exposure += stops; });
}

void next_overlay(Workbench& bench) {
  bench.settings.change_with([](ViewSettings& s) {
    s.overlay = ViewOverlay((size_t(s.overlay) + 1) % overlay_table().size());
  });
}

struct Effect {
  Action action;
  void (*act)(Workbench& bench, int number);
};

// One effect per action, in the order of the enum.
constexpr std::array kEffects = {
    Effect{Action::kOpen, [](Workbench& b, int) { b.interface.scene_dialog_requested = true; }},
    Effect{Action::kReload, [](Workbench& b, int) { b.files.reload(); }},
    Effect{Action::kSaveEdits, [](Workbench& b, int) { b.files.save_edits(); }},
    Effect{Action::kSavePicture,
           [](Workbench& b, int) { b.interface.save_dialog_requested = true; }},
    Effect{Action::kScreenshot, [](Workbench& b, int) { b.interface.screenshot_requested = true; }},
    Effect{Action::kQuit, [](Workbench& b, int) { b.interface.quit = true; }},
    Effect{Action::kUndo, [](Workbench& b, int) { undo(b); }},
    Effect{Action::kRedo, [](Workbench& b, int) { redo(b); }},
    Effect{Action::kResetEdits, [](Workbench& b, int) { b.edits.change(SceneEdits(), "reset"); }},
    Effect{Action::kPause, [](Workbench& b, int) { toggle_pause(b); }},
    Effect{Action::kRestart, [](Workbench& b, int) { restart(b); }},
    Effect{Action::kPlay, [](Workbench& b, int) { b.player.toggle_playing(); }},
    Effect{Action::kNextFrame, [](Workbench& b, int) { b.player.step(1); }},
    Effect{Action::kPreviousFrame, [](Workbench& b, int) { b.player.step(-1); }},
    Effect{Action::kFrameAll, [](Workbench& b, int) { b.navigator.frame_all(); }},
    Effect{Action::kResetCamera, [](Workbench& b, int) { b.navigator.reset(); }},
    Effect{Action::kOrthographic,
           [](Workbench& b, int) { b.navigator.set_orthographic(!b.navigator.orthographic()); }},
    Effect{Action::kRecallBookmark, [](Workbench& b, int i) { b.navigator.recall_bookmark(i); }},
    Effect{Action::kStoreBookmark, [](Workbench& b, int i) { b.navigator.store_bookmark(i); }},
    Effect{Action::kZoomFit, [](Workbench& b, int) { b.placement.fit(); }},
    Effect{Action::kZoomOne, [](Workbench& b, int) { zoom_to_one_or_fit(b); }},
    Effect{Action::kZoomIn,
           [](Workbench& b, int) { b.placement.zoom_to(b.placement.zoom() * kZoomStep); }},
    Effect{Action::kZoomOut,
           [](Workbench& b, int) { b.placement.zoom_to(b.placement.zoom() / kZoomStep); }},
    Effect{Action::kExposureUp, [](Workbench& b, int) { add_exposure(b, kExposureStep); }},
    Effect{Action::kExposureDown, [](Workbench& b, int) { add_exposure(b, -kExposureStep); }},
    Effect{Action::kNextOverlay, [](Workbench& b, int) { next_overlay(b); }},
    Effect{Action::kDenoise, [](Workbench& b, int) { b.comparison.toggle_denoise(); }},
    Effect{Action::kInspector, [](Workbench& b, int) { b.pixels.toggle(); }},
    Effect{Action::kExplain, [](Workbench& b, int) { b.pixels.toggle_explanation(); }},
    Effect{Action::kCopyPixel, [](Workbench& b, int) { b.pixels.copy_values(); }},
    Effect{Action::kStoreSnapshot, [](Workbench& b, int) { b.comparison.store(b.picture()); }},
    Effect{Action::kWipe, [](Workbench& b, int) { b.comparison.toggle(Wipe::kStored); }},
    Effect{Action::kWipeRaw, [](Workbench& b, int) { b.comparison.toggle(Wipe::kRaw); }},
    Effect{Action::kClearRegion, [](Workbench& b, int) { clear_region(b); }},
    Effect{Action::kPanels, [](Workbench& b, int) { flip(b.window.panels); }},
    Effect{Action::kFullScreen, [](Workbench& b, int) { flip(b.interface.full_screen); }},
    Effect{Action::kShortcuts, [](Workbench& b, int) { flip(b.interface.show_shortcuts); }},
    Effect{Action::kMessages, [](Workbench& b, int) { flip(b.interface.show_messages); }},
};

constexpr bool every_action_in_order() {
  for (size_t i = 0; i < kEffects.size(); ++i) {
    if (kEffects[i].action != Action(i)) return false;
  }
  return kEffects.back().action == Action::kMessages;
}
static_assert(every_action_in_order());

}  // namespace

void Workbench::act(Action action, int number) { kEffects[size_t(action)].act(*this, number); }

}  // namespace emberline
