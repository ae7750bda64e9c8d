// The menu bar.
#include <imgui.h>

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"

namespace emberline {
namespace {

void menu_entry(Workbench& bench, const char* name, Action action, bool enabled = true,
                bool ticked = false) {
  const std::string keys(keys_of(action));
  if (ImGui::MenuItem(name, keys.c_str(), ticked, enabled)) bench.act(action);
}

// Options for reading files; a change reloads the open file.
void choose_loading(Workbench& bench) {
  ViewSettings settings = bench.session.settings();
  bool changed =
      ImGui::MenuItem("Go on without images that cannot be read", "", &settings.render.lenient);
  changed |=
      ImGui::MenuItem("Show one-sided surfaces from behind", "", &settings.render.show_backfaces);
  if (!changed) return;
  bench.settings.change(settings);
  bench.files.reload();
}

void draw_file_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("File")) return;
  const bool open = bench.session.scene() != nullptr;
  menu_entry(bench, "Open scene…", Action::kOpen);
  const std::vector<std::string>& recent = bench.window.recent_scenes;
  if (ImGui::BeginMenu("Open recent", !recent.empty())) {
    for (const std::string& scene : recent) {
      if (ImGui::MenuItem(scene.c_str())) bench.files.open(scene);
    }
    ImGui::EndMenu();
  }
  menu_entry(bench, "Reload", Action::kReload, open);
  if (ImGui::BeginMenu("Loading")) {
    choose_loading(bench);
    ImGui::EndMenu();
  }
  ImGui::Separator();
  menu_entry(bench, "Save edits", Action::kSaveEdits, open);
  menu_entry(bench, "Save picture…", Action::kSavePicture, open);
  menu_entry(bench, "Save the window's picture", Action::kScreenshot);
  ImGui::Separator();
  menu_entry(bench, "Quit", Action::kQuit);
  ImGui::EndMenu();
}

void draw_camera_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("Camera")) return;
  const bool open = bench.session.scene() != nullptr;
  menu_entry(bench, "Frame all", Action::kFrameAll, open);
  menu_entry(bench, "Reset", Action::kResetCamera, open);
  menu_entry(bench, "Orthographic", Action::kOrthographic, open, bench.navigator.orthographic());
  ImGui::EndMenu();
}

void draw_time_menu(Workbench& bench) {
  if (!bench.player.available() || !ImGui::BeginMenu("Time")) return;
  menu_entry(bench, "Play", Action::kPlay, true, bench.player.playing());
  menu_entry(bench, "Next frame", Action::kNextFrame);
  menu_entry(bench, "Previous frame", Action::kPreviousFrame);
  ImGui::EndMenu();
}

void draw_edit_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("Edit")) return;
  menu_entry(bench, "Undo", Action::kUndo, bench.edits.can_undo());
  menu_entry(bench, "Redo", Action::kRedo, bench.edits.can_redo());
  ImGui::Separator();
  menu_entry(bench, "Reset edits", Action::kResetEdits, bench.session.scene() != nullptr);
  ImGui::EndMenu();
}

void draw_view_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("View")) return;
  const bool open = bench.session.scene() != nullptr;
  const bool denoise = bench.session.settings().denoise;
  const Comparison& comparison = bench.comparison;
  const Wipe wipe = comparison.wipe();
  menu_entry(bench, "Fit", Action::kZoomFit, true, bench.placement.fitted());
  menu_entry(bench, "One to one", Action::kZoomOne);
  ImGui::Separator();
  menu_entry(bench, "Keep as B", Action::kStoreSnapshot, open);
  menu_entry(bench, "Wipe A / B", Action::kWipe, comparison.kept().picture != nullptr,
             wipe == Wipe::kKept);
  menu_entry(bench, "Denoise", Action::kDenoise, true, denoise);
  menu_entry(bench, "Wipe raw", Action::kWipeRaw, denoise, wipe == Wipe::kRaw);
  menu_entry(bench, "Next overlay", Action::kNextOverlay, open);
  menu_entry(bench, "Pixel values", Action::kInspector, true, bench.window.inspector);
  menu_entry(bench, "Why is this pixel done?", Action::kExplain, open, bench.pixels.explains());
  ImGui::Separator();
  menu_entry(bench, "Panels", Action::kPanels, true, bench.window.panels);
  menu_entry(bench, "Full screen", Action::kFullScreen, true, bench.interface.full_screen);
  ImGui::EndMenu();
}

void draw_help_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("Help")) return;
  menu_entry(bench, "Shortcuts", Action::kShortcuts, true, bench.interface.show_shortcuts);
  menu_entry(bench, "Messages", Action::kMessages, true, bench.interface.show_messages);
  ImGui::EndMenu();
}

// Drawn to the right of the menus.
void draw_file_name(const Workbench& bench) {
  const std::string name = std::filesystem::path(bench.load_status().path).filename().string() +
                           (bench.edits.unsaved() ? "  •  edits not saved" : "");
  ImGui::SameLine(ImGui::GetWindowWidth() - ImGui::CalcTextSize(name.c_str()).x -
                  ImGui::GetFontSize());
  ImGui::TextColored(quiet_colour(), "%s", name.c_str());
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
