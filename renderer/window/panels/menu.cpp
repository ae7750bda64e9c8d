// The menu bar.
#include <imgui.h>

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/window/panels/action_widgets.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

// Menu entries for the loading options. A change reloads the open scene.
void choose_loading(Workbench& bench) {
  ViewSettings settings = bench.session.settings();
  bool changed = widgets::menu_flag("Ignore Unreadable Images",
                                    "Open the scene even if images are missing or damaged",
                                    settings.render.lenient);
  changed |= widgets::menu_flag("Show Backfaces", "Also show one-sided surfaces from behind",
                                settings.render.show_backfaces);
  if (!changed) return;
  bench.settings.change(settings);
  bench.files.reload();
}

void draw_file_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("File")) return;
  const bool open = bench.session.scene() != nullptr;
  action_entry(bench, "Open…", Action::kOpen);
  const std::vector<std::string>& recent = bench.window.recent_scenes;
  if (ImGui::BeginMenu("Open Recent", !recent.empty())) {
    for (const std::string& scene : recent) {
      const bool chosen = ImGui::MenuItem(scene.c_str());
      widgets::help(Help("Open this scene"));
      if (chosen) bench.files.open(scene);
    }
    ImGui::EndMenu();
  }
  action_entry(bench, "Reload", Action::kReload, open);
  if (ImGui::BeginMenu("Loading")) {
    choose_loading(bench);
    ImGui::EndMenu();
  }
  ImGui::Separator();
  action_entry(bench, "Save Edits", Action::kSaveEdits, open);
  action_entry(bench, "Save Picture…", Action::kSavePicture, open);
  action_entry(bench, "Save Screenshot", Action::kScreenshot);
  ImGui::Separator();
  action_entry(bench, "Quit", Action::kQuit);
  ImGui::EndMenu();
}

void draw_camera_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("Camera")) return;
  const bool open = bench.session.scene() != nullptr;
  action_entry(bench, "Frame All", Action::kFrameAll, open);
  action_entry(bench, "Reset", Action::kResetCamera, open);
  action_entry(bench, "Orthographic", Action::kOrthographic, open, bench.navigator.orthographic());
  ImGui::EndMenu();
}

void draw_time_menu(Workbench& bench) {
  if (!bench.player.available() || !ImGui::BeginMenu("Time")) return;
  action_entry(bench, "Play", Action::kPlay, true, bench.player.playing());
  action_entry(bench, "Next Frame", Action::kNextFrame);
  action_entry(bench, "Previous Frame", Action::kPreviousFrame);
  ImGui::EndMenu();
}

void draw_edit_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("Edit")) return;
  action_entry(bench, "Undo", Action::kUndo, bench.edits.can_undo());
  action_entry(bench, "Redo", Action::kRedo, bench.edits.can_redo());
  ImGui::Separator();
  action_entry(bench, "Reset Edits", Action::kResetEdits, bench.session.scene() != nullptr);
  ImGui::EndMenu();
}

void draw_view_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("View")) return;
  const bool open = bench.session.scene() != nullptr;
  const bool denoise = bench.session.settings().denoise;
  const Comparison& comparison = bench.comparison;
  const Wipe wipe = comparison.wipe();
  action_entry(bench, "Fit to Window", Action::kZoomFit, true, bench.placement.fitted());
  action_entry(bench, "Actual Size", Action::kZoomOne);
  ImGui::Separator();
  action_entry(bench, "Keep as B", Action::kStoreSnapshot, open);
  action_entry(bench, "Wipe A/B", Action::kWipe, comparison.stored().picture != nullptr,
               wipe == Wipe::kStored);
  action_entry(bench, "Denoise", Action::kDenoise, true, denoise);
  action_entry(bench, "Wipe Denoised/Raw", Action::kWipeRaw, denoise, wipe == Wipe::kRaw);
  action_entry(bench, "Next Overlay", Action::kNextOverlay, open);
  action_entry(bench, "Pixel Values", Action::kInspector, true, bench.window.inspector);
  action_entry(bench, "Explain Pixel", Action::kExplain, open, bench.pixels.shows_explanation());
  ImGui::Separator();
  action_entry(bench, "Side Panel", Action::kPanels, true, bench.window.panels);
  action_entry(bench, "Full Screen", Action::kFullScreen, true, bench.interface.full_screen);
  ImGui::EndMenu();
}

void draw_help_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("Help")) return;
  action_entry(bench, "Shortcuts", Action::kShortcuts, true, bench.interface.show_shortcuts);
  action_entry(bench, "Messages", Action::kMessages, true, bench.interface.show_messages);
  ImGui::EndMenu();
}

// Draws the name of the scene's file to the right of the menus.
void draw_file_name(const Workbench& bench) {
  const std::string name = std::filesystem::path(bench.load_status().path).filename().string() +
                           (bench.edits.has_unsaved_edits() ? "  •  unsaved edits" : "");
  ImGui::SameLine(ImGui::GetWindowWidth() - ImGui::CalcTextSize(name.c_str()).x -
                  ImGui::GetFontSize());
  ImGui::TextColored(muted_colour(), "%s", name.c_str());
}

}  // namespace

void draw_menu(Workbench& bench) {
  if (!ImGui::BeginMainMenuBar()) return;
  draw_file_menu(bench);
  draw_edit_menu(bench);
  draw_camera_menu(bench);
  draw_time_menu(bench);
  draw_view_menu(bench);
  draw_help_menu(bench);
  if (bench.session.scene()) draw_file_name(bench);
  ImGui::EndMainMenuBar();
}

}  // namespace emberline
