#include "renderer/window/panels/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "renderer/core/readable.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

constexpr float kLeastPanel = 22.0f, kMostPanel = 45.0f;  // in heights of a line
constexpr double kNoticeTime_s = 6.0, kErrorTime_s = 60.0;
constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr ImGuiWindowFlags kNote =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoMove;

struct Tab {
  const char* name;
  void (*draw)(Workbench&);
};
constexpr std::array kTabs = {Tab{"Lights", draw_lights}, Tab{"Materials", draw_materials},
                              Tab{"Camera", draw_camera}, Tab{"Render", draw_sampling},
                              Tab{"Display", draw_display}};
constexpr int kMaterialsTab = 1;

ImVec4 level_colour(Message::Level level) {
  if (level == Message::Level::kError) return error_colour();
  if (level == Message::Level::kWarning) return warning_colour();
  return ImGui::GetStyleColorVec4(ImGuiCol_Text);
}

void menu_entry(Workbench& bench, const char* name, Action action, bool enabled = true,
                bool ticked = false) {
  const std::string keys(keys_of(action));
  if (ImGui::MenuItem(name, keys.c_str(), ticked, enabled)) bench.act(action);
}

// What is decided while a file is read: a change reads the open one anew.
void choose_loading(Workbench& bench) {
  ViewSettings settings = bench.settings();
  bool changed =
      ImGui::MenuItem("Go on without images that cannot be read", "", &settings.render.lenient);
  changed |=
      ImGui::MenuItem("Show one-sided surfaces from behind", "", &settings.render.show_backfaces);
  if (!changed) return;
  bench.change(settings);
  bench.reload();
}

// What the status line says, from left to right: what is at work, how far, how fast.
std::vector<std::string> status(const Workbench& bench) {
  std::vector<std::string> parts;
  if (!bench.picture()) return parts;
  const ShownPicture& p = *bench.picture();
  const uint64_t pixels = uint64_t(p.width) * uint64_t(p.height);
  parts.push_back(bench.settings().paused ? "paused" : p.finished ? "finished" : p.driver);
  if (!p.complete) {
    parts.push_back(readable_percent(p.progress.completion) + " of the first pass");
  }
  if (pixels > 0) {
    const double per_pixel = double(p.samples) / double(pixels);
    parts.push_back(fmt::format("{:.{}f} samples/px", per_pixel, per_pixel < 100.0 ? 1 : 0));
  }
  parts.push_back(readable_seconds(p.elapsed_s));
  if (p.progress.error_estimate) {
    parts.push_back("error " + readable_number(*p.progress.error_estimate, 2));
  }
  if (p.rendering_s > 0.0 && p.rays > 0) {
    parts.push_back(fmt::format("{:.2f} Mrays/s", 1e-6 * double(p.rays) / p.rendering_s));
  }
  if (const auto latency = bench.latency.newest_s()) {
    parts.push_back(fmt::format("edit {:.0f} ms", 1e3 * *latency));
  }
  return parts;
}

std::string right_status(const Workbench& bench) {
  std::string text;
  if (bench.solo()) text += "solo   ";
  if (bench.wipe || bench.wipe_raw) text += bench.wipe ? "A | B   " : "denoised | raw   ";
  if (const auto& pixel = bench.pointed_pixel()) {
    text += fmt::format("{}, {}   ", pixel->x, pixel->y);
  }
  if (bench.picture()) {
    text += fmt::format("{} × {}   {:.0f} %", bench.picture()->width, bench.picture()->height,
                        100.0 * bench.placement.zoom() * ImGui::GetIO().DisplayFramebufferScale.x);
  }
  return text;
}

}  // namespace

void Interface::draw(Workbench& bench, float width, float height) {
  floating_.clear();
  draw_menu(bench);
  const float top = ImGui::GetFrameHeight();
  const float bottom = height - ImGui::GetFrameHeight() - 2.0f;
  const float em = ImGui::GetFontSize();
  const float panel =
      bench.window.panels ? std::min(bench.window.panel_width * em, 0.6f * width) : 0.0f;
  if (bench.window.panels) draw_side_panel(bench, top, width, bottom);
  draw_status_line(bench, width, height);
  const float time_line = time_line_height(bench);
  draw_time_line(bench, bottom - time_line, width - panel);
  const Rect area{0, int(top), int(width - panel), int(bottom - time_line)};
  const int frame_width = bench.picture() ? bench.picture()->width : bench.settings().render.width;
  const int frame_height =
      bench.picture() ? bench.picture()->height : bench.settings().render.height;
  bench.placement.place(area, frame_width, frame_height);
  draw_welcome(bench);
  draw_loading(bench);
  draw_notice(bench);
  draw_shortcuts(bench);
  draw_messages(bench);
  draw_explanation(bench);
  draw_dialogs(bench);
  popup_ = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
}

bool Interface::covers(const Vec2f& point) const {
  return popup_ || std::ranges::any_of(floating_, [&](const Rect& rect) {
           return rect.contains(int(point.x), int(point.y));
         });
}

void Interface::take_place() {
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  floating_.push_back({int(at.x), int(at.y), int(at.x + size.x), int(at.y + size.y)});
}

void Interface::cancel_dialogs() {
  for (FileDialog* dialog : {&open_dialog_, &environment_dialog_, &save_dialog_}) dialog->cancel();
}

void Interface::draw_file_menu(Workbench& bench) {
  if (!ImGui::BeginMenu("File")) return;
  const bool open = bench.scene() != nullptr;
  menu_entry(bench, "Open scene…", Action::kOpen);
  if (ImGui::BeginMenu("Open recent", !bench.window.recent_scenes.empty())) {
    const std::vector<std::string> recent = bench.window.recent_scenes;
    for (const std::string& scene : recent) {
      if (ImGui::MenuItem(scene.c_str())) bench.open(scene);
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

void Interface::draw_menu(Workbench& bench) {
  if (!ImGui::BeginMainMenuBar()) return;
  const bool open = bench.scene() != nullptr;
  draw_file_menu(bench);
  if (ImGui::BeginMenu("Edit")) {
    menu_entry(bench, "Undo", Action::kUndo, bench.can_undo());
    menu_entry(bench, "Redo", Action::kRedo, bench.can_redo());
    ImGui::Separator();
    menu_entry(bench, "Take all edits back", Action::kResetEdits, open);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Camera")) {
    menu_entry(bench, "Frame all", Action::kFrameAll, open);
    menu_entry(bench, "Reset", Action::kResetCamera, open);
    menu_entry(bench, "Orthographic", Action::kOrthographic, open, bench.orthographic());
    ImGui::EndMenu();
  }
  if (bench.has_time_line() && ImGui::BeginMenu("Time")) {
    menu_entry(bench, "Play", Action::kPlay, true, bench.playback.playing());
    menu_entry(bench, "Next frame", Action::kNextFrame);
    menu_entry(bench, "Previous frame", Action::kPreviousFrame);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("View")) {
    menu_entry(bench, "Fit", Action::kZoomFit, true, bench.placement.fitted());
    menu_entry(bench, "One to one", Action::kZoomOne);
    ImGui::Separator();
    menu_entry(bench, "Keep as B", Action::kStoreSnapshot, open);
    menu_entry(bench, "Wipe A / B", Action::kWipe, bench.kept.picture != nullptr, bench.wipe);
    menu_entry(bench, "Denoise", Action::kDenoise, true, bench.settings().denoise);
    menu_entry(bench, "Wipe raw", Action::kWipeRaw, bench.settings().denoise, bench.wipe_raw);
    menu_entry(bench, "Next overlay", Action::kNextOverlay, open);
    menu_entry(bench, "Pixel values", Action::kInspector, true, bench.show_inspector);
    menu_entry(bench, "Why is this pixel done?", Action::kExplain, open, bench.show_explanation);
    ImGui::Separator();
    menu_entry(bench, "Panels", Action::kPanels, true, bench.window.panels);
    menu_entry(bench, "Full screen", Action::kFullScreen, true, bench.full_screen);
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Help")) {
    menu_entry(bench, "Shortcuts", Action::kShortcuts, true, bench.show_shortcuts);
    menu_entry(bench, "Messages", Action::kMessages, true, bench.show_messages);
    ImGui::EndMenu();
  }
  if (open) {
    const std::string name = std::filesystem::path(bench.load_status().path).filename().string() +
                             (bench.unsaved() ? "  •  edits not saved" : "");
    ImGui::SameLine(ImGui::GetWindowWidth() - ImGui::CalcTextSize(name.c_str()).x -
                    ImGui::GetFontSize());
    ImGui::TextColored(quiet_colour(), "%s", name.c_str());
  }
  ImGui::EndMainMenuBar();
}

void Interface::draw_side_panel(Workbench& bench, float top, float width, float bottom) {
  const float em = ImGui::GetFontSize();
  const float most = 0.6f * width;
  const float wanted = std::min(bench.window.panel_width * em, most);
  ImGui::SetNextWindowPos({width - wanted, top});
  ImGui::SetNextWindowSize({wanted, bottom - top});
  // Its ground is what the window is cleared to: nothing more to be drawn.
  ImGui::Begin("##panel", nullptr,
               kFixed | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoBackground);
  if (ImGui::BeginTabBar("##tabs", ImGuiTabBarFlags_FittingPolicyResizeDown)) {
    for (int i = 0; i < int(kTabs.size()); ++i) {
      const bool remembered = !tab_chosen_ && i == bench.window.panel_tab;
      const bool picked = i == kMaterialsTab && std::exchange(bench.show_material, false);
      if (!ImGui::BeginTabItem(kTabs[size_t(i)].name, nullptr,
                               remembered || picked ? ImGuiTabItemFlags_SetSelected : 0)) {
        continue;
      }
      if (tab_chosen_) bench.window.panel_tab = i;
      ImGui::BeginChild("##content", {0.0f, 0.0f}, false);
      kTabs[size_t(i)].draw(bench);
      ImGui::EndChild();
      ImGui::EndTabItem();
    }
    tab_chosen_ = true;
    ImGui::EndTabBar();
  }
  ImGui::End();

  // Its left edge can be dragged.
  ImGui::SetNextWindowPos({width - wanted - 3.0f, top});
  ImGui::SetNextWindowSize({6.0f, bottom - top});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1.0f, 1.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.0f, 0.0f));
  ImGui::Begin("##edge", nullptr,
               (kFixed & ~ImGuiWindowFlags_NoBringToFrontOnFocus) | ImGuiWindowFlags_NoBackground);
  ImGui::InvisibleButton("##grip", {6.0f, bottom - top});
  if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  }
  if (ImGui::IsItemActive()) {
    bench.window.panel_width =
        std::clamp((width - ImGui::GetIO().MousePos.x) / em, kLeastPanel, kMostPanel);
  }
  take_place();
  ImGui::End();
  ImGui::PopStyleVar(2);
}

void Interface::draw_status_line(const Workbench& bench, float width, float height) {
  const float line = ImGui::GetFrameHeight() + 2.0f;
  ImGui::SetNextWindowPos({0.0f, height - line});
  ImGui::SetNextWindowSize({width, line});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.7f * ImGui::GetFontSize(), 1.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1.0f, 1.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImGui::GetStyleColorVec4(ImGuiCol_MenuBarBg));
  ImGui::Begin("##status", nullptr, kFixed | ImGuiWindowFlags_NoScrollbar);
  ImGui::AlignTextToFramePadding();
  const std::string right = right_status(bench);
  const float right_at = ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(right.c_str()).x;
  bool first = true;
  for (const std::string& part : status(bench)) {
    if (!first) ImGui::SameLine(0.0f, 1.4f * ImGui::GetFontSize());
    if (ImGui::GetCursorPosX() + ImGui::CalcTextSize(part.c_str()).x > right_at) break;
    ImGui::TextColored(first ? accent_colour() : ImGui::GetStyleColorVec4(ImGuiCol_Text), "%s",
                       part.c_str());
    first = false;
  }
  if (first) ImGui::TextUnformatted("");
  ImGui::SameLine(right_at);
  ImGui::TextColored(quiet_colour(), "%s", right.c_str());
  // A thin line along the upper edge: how far the first pass is.
  if (bench.picture() && !bench.picture()->complete) {
    const auto part = float(bench.picture()->progress.completion);
    ImGui::GetWindowDrawList()->AddRectFilled({0.0f, height - line},
                                              {width * part, height - line + 2.0f},
                                              ImGui::GetColorU32(accent_colour()));
  }
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(3);
}

void Interface::draw_welcome(Workbench& bench) {
  if (bench.scene() || bench.load_status().state == LoadStatus::State::kLoading) return;
  const Rect& area = bench.placement.area();
  ImGui::SetNextWindowPos({0.5f * float(area.x0 + area.x1), 0.45f * float(area.y0 + area.y1)},
                          ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::Begin("##welcome", nullptr, kNote);
  ImGui::TextUnformatted("Drop a .gltf or .glb file here");
  if (ImGui::Button("Open scene…", {-FLT_MIN, 0.0f})) bench.act(Action::kOpen);
  if (!bench.window.recent_scenes.empty()) widgets::heading("Recent");
  const std::vector<std::string> recent = bench.window.recent_scenes;
  for (const std::string& scene : recent) {
    if (ImGui::Selectable(std::filesystem::path(scene).filename().string().c_str())) {
      bench.open(scene);
    }
    if (ImGui::IsItemHovered()) widgets::help(scene);
  }
  take_place();
  ImGui::End();
}

void Interface::draw_loading(Workbench& bench) {
  const LoadStatus& status = bench.load_status();
  if (status.state != LoadStatus::State::kLoading) return;
  const Rect& area = bench.placement.area();
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({0.5f * float(area.x0 + area.x1), 0.5f * float(area.y0 + area.y1)},
                          ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::Begin("##loading", nullptr, kNote);
  const std::string name = std::filesystem::path(status.path).filename().string();
  ImGui::Text("Loading %s", name.c_str());
  ImGui::ProgressBar(float(status.fraction), {22.0f * em, 0.4f * em}, "");
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(quiet_colour(), "%s", status.stage.c_str());
  ImGui::SameLine(16.0f * em);
  if (ImGui::Button("Cancel", {6.0f * em + ImGui::GetStyle().WindowPadding.x, 0.0f})) {
    bench.session().cancel_load();
  }
  take_place();
  ImGui::End();
}

// The newest message, over the lower edge of the picture for a while; an error until it is closed.
void Interface::draw_notice(Workbench& bench) {
  if (bench.messages().empty()) return;
  const Message& message = bench.messages().back();
  const bool error = message.level == Message::Level::kError;
  const double age = Workbench::now() - message.time_s;
  if (message.time_s <= dismissed_s_ || age > (error ? kErrorTime_s : kNoticeTime_s)) return;
  const Rect& area = bench.placement.area();
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({float(area.x0) + em, float(area.y1) - em}, ImGuiCond_Always,
                          {0.0f, 1.0f});
  ImGui::SetNextWindowBgAlpha(0.92f);
  ImGui::Begin("##notice", nullptr, kNote);
  ImGui::PushTextWrapPos(std::min(48.0f * em, float(area.width()) - 6.0f * em));
  ImGui::PushStyleColor(ImGuiCol_Text, level_colour(message.level));
  ImGui::TextUnformatted(message.text.c_str());
  ImGui::PopStyleColor();
  ImGui::PopTextWrapPos();
  if (message.level != Message::Level::kNote) {
    if (ImGui::SmallButton("Close")) dismissed_s_ = message.time_s;
    ImGui::SameLine();
    if (ImGui::SmallButton("All messages")) bench.show_messages = true;
  }
  take_place();
  ImGui::End();
}

namespace {

void shortcut_row(std::string_view keys, std::string_view effect) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(accent_colour(), "%.*s", int(keys.size()), keys.data());
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(effect.data(), effect.data() + effect.size());
}

void shortcut_heading(std::string_view text) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextColored(quiet_colour(), "%.*s", int(text.size()), text.data());
}

// The groups up to that of the picture, or from there on: two columns of about equal length.
void list_keys(bool second_half) {
  std::string_view group;
  bool in_second = false;
  for (const Shortcut& entry : shortcut_table()) {
    in_second |= entry.group == "Picture";
    if (!entry.listed || in_second != second_half) continue;
    if (entry.group != group) shortcut_heading(group = entry.group);
    shortcut_row(entry.keys, entry.effect);
  }
}

void list_mouse() {
  shortcut_heading("Mouse");
  for (const DragGesture& entry : drag_table()) shortcut_row(entry.keys, entry.effect);
  for (const ListedGesture& entry : listed_gestures()) shortcut_row(entry.keys, entry.effect);
}

void list_flight() {
  shortcut_heading("Fly");
  for (const FlightKey& entry : flight_table()) shortcut_row(entry.keys, entry.effect);
}

}  // namespace

void Interface::draw_shortcuts(Workbench& bench) {
  if (!bench.show_shortcuts) return;
  const float em = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * screen.x, 0.5f * screen.y}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(
      {std::min(58.0f * em, 0.95f * screen.x), std::min(44.0f * em, 0.9f * screen.y)},
      ImGuiCond_Appearing);
  if (ImGui::Begin("Shortcuts", &bench.show_shortcuts, ImGuiWindowFlags_NoSavedSettings)) {
    if (ImGui::BeginTable("##halves", 2)) {
      ImGui::TableNextColumn();
      if (ImGui::BeginTable("##keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        list_keys(false);
        list_flight();
        ImGui::EndTable();
      }
      ImGui::TableNextColumn();
      if (ImGui::BeginTable("##mouse", 2, ImGuiTableFlags_SizingFixedFit)) {
        list_mouse();
        list_keys(true);
        ImGui::EndTable();
      }
      ImGui::EndTable();
    }
  }
  take_place();
  ImGui::End();
}

void Interface::draw_messages(Workbench& bench) {
  if (!bench.show_messages) return;
  const float em = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({2.0f * em, screen.y - 3.0f * em}, ImGuiCond_Appearing, {0.0f, 1.0f});
  ImGui::SetNextWindowSize(
      {std::min(52.0f * em, 0.9f * screen.x), std::min(16.0f * em, 0.6f * screen.y)},
      ImGuiCond_Appearing);
  if (ImGui::Begin("Messages", &bench.show_messages, ImGuiWindowFlags_NoSavedSettings)) {
    ImGui::PushTextWrapPos(0.0f);
    for (const Message& message : bench.messages()) {
      ImGui::TextColored(quiet_colour(), "%7.1f s", message.time_s);
      ImGui::SameLine();
      ImGui::PushStyleColor(ImGuiCol_Text, level_colour(message.level));
      ImGui::TextUnformatted(message.text.c_str());
      ImGui::PopStyleColor();
    }
    ImGui::PopTextWrapPos();
    if (bench.messages().empty()) ImGui::TextColored(quiet_colour(), "none so far");
    if (ImGui::GetScrollY() >= ImGui::GetScrollMaxY()) ImGui::SetScrollHereY(1.0f);
  }
  take_place();
  ImGui::End();
}

void Interface::draw_dialogs(Workbench& bench) {
  const std::string& scene = bench.load_status().path;
  if (std::exchange(bench.ask_for_scene, false)) open_dialog_.open(scene);
  open_dialog_.draw([&](const std::string& path) { bench.open_dropped(path); });
  if (std::exchange(bench.ask_for_environment, false)) {
    const std::string& now = bench.edits().environment.file;
    environment_dialog_.open(now.empty() ? scene : now);
  }
  environment_dialog_.draw([&](const std::string& path) { bench.set_environment(path); });
  if (std::exchange(bench.ask_for_picture_file, false)) {
    const std::filesystem::path stem = std::filesystem::path(scene).stem();
    const bool heatmap = bench.settings().overlay != ViewOverlay::kNone;
    save_dialog_.open((stem.string() + (heatmap ? "-heatmap.png" : ".exr")));
  }
  save_dialog_.draw([&](const std::string& path) {
    const ViewOverlay overlay = bench.settings().overlay;
    if (overlay == ViewOverlay::kNone || path.ends_with(".exr")) return bench.save_picture(path);
    bench.save_heatmap(path, overlay);
  });
  const char* asking = "";
  for (const FileDialog* dialog : {&open_dialog_, &environment_dialog_, &save_dialog_}) {
    if (dialog->has_keyboard()) asking = dialog->title();
  }
  bench.note_dialog(asking);
}

}  // namespace emberline
