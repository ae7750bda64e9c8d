#include "renderer/window/panels/panels.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

constexpr float kMinPanelWidth = 22.0f, kMaxPanelWidth = 45.0f;  // in line heights

struct Tab {
  const char* name;
  Help help;
  void (*draw)(Workbench&);
};
constexpr std::array kTabs = {
    Tab{"Lights", "Edit lights and the environment", draw_lights},
    Tab{"Materials", "Edit materials", draw_materials},
    Tab{"Camera", "Edit the camera and its lens, and store bookmarks", draw_camera},
    Tab{"Render", "Choose how the picture is rendered", draw_sampling},
    Tab{"Display", "Choose how the picture is shown, and compare pictures", draw_display}};
constexpr int kMaterialsTab = 1;

float panel_width(const WindowState& window, float width) {
  return std::min(window.panel_width * ImGui::GetFontSize(), 0.6f * width);
}

}  // namespace

void Interface::draw(Workbench& bench, float width, float height) {
  floating_windows_.clear();
  draw_menu(bench);
  const float top = ImGui::GetFrameHeight();
  const float bottom = height - ImGui::GetFrameHeight() - 2.0f;
  const float panel = bench.window.panels ? panel_width(bench.window, width) : 0.0f;
  if (bench.window.panels) draw_side_panel(bench, top, width, bottom);
  draw_status_line(bench, width, height);
  const float time_line = time_line_height(bench);
  draw_time_line(bench, bottom - time_line, width - panel);
  const Rect area{0, int(top), int(width - panel), int(bottom - time_line)};
  const std::shared_ptr<const SessionPicture>& picture = bench.picture();
  const RenderOptions& options = bench.session.settings().render;
  bench.placement.place(area, picture ? picture->width : options.width,
                        picture ? picture->height : options.height);
  draw_welcome(bench);
  draw_loading(bench);
  draw_notice(bench);
  draw_shortcuts(bench);
  draw_messages(bench);
  draw_explanation(bench);
  draw_dialogs(bench);
  is_popup_open_ =
      ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
}

bool Interface::covers(const Vec2f& point) const {
  return is_popup_open_ || std::ranges::any_of(floating_windows_, [&](const Rect& rect) {
           return rect.contains(int(point.x), int(point.y));
         });
}

void Interface::register_window() {
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  floating_windows_.push_back({int(at.x), int(at.y), int(at.x + size.x), int(at.y + size.y)});
}

const char* Interface::focused_dialog() const {
  for (const FileDialog* dialog : {&open_dialog_, &environment_dialog_, &save_dialog_}) {
    if (dialog->has_keyboard()) return dialog->title();
  }
  return "";
}

void Interface::cancel_dialogs() {
  for (FileDialog* dialog : {&open_dialog_, &environment_dialog_, &save_dialog_}) dialog->cancel();
}

void Interface::draw_side_panel(Workbench& bench, float top, float width, float bottom) {
  const float panel = panel_width(bench.window, width);
  ImGui::SetNextWindowPos({width - panel, top});
  ImGui::SetNextWindowSize({panel, bottom - top});
  // The panel needs no background, because the frame buffer has already been cleared to the panel's
  // colour.
  ImGui::Begin("##panel", nullptr, fixed_panel_flags() | ImGuiWindowFlags_NoBackground);
  if (ImGui::BeginTabBar("##tabs", ImGuiTabBarFlags_FittingPolicyResizeDown)) {
    for (int i = 0; i < int(kTabs.size()); ++i) {
      const bool remembered = !is_tab_restored_ && i == bench.window.panel_tab;
      const bool picked = i == kMaterialsTab && std::exchange(bench.selection.show_tab, false);
      const bool shown = ImGui::BeginTabItem(
          kTabs[size_t(i)].name, nullptr, remembered || picked ? ImGuiTabItemFlags_SetSelected : 0);
      widgets::help(kTabs[size_t(i)].help);
      if (!shown) continue;
      if (is_tab_restored_) bench.window.panel_tab = i;
      ImGui::BeginChild("##content", {0.0f, 0.0f}, false);
      kTabs[size_t(i)].draw(bench);
      ImGui::EndChild();
      ImGui::EndTabItem();
    }
    is_tab_restored_ = true;
    ImGui::EndTabBar();
  }
  ImGui::End();
  draw_panel_edge(bench.window, top, width, bottom - top);
}

// Draws the handle on the side panel's left edge, which resizes the panel.
void Interface::draw_panel_edge(WindowState& window, float top, float width, float height) {
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({width - panel_width(window, width) - 3.0f, top});
  ImGui::SetNextWindowSize({6.0f, height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1.0f, 1.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.0f, 0.0f));
  ImGui::Begin("##edge", nullptr,
               (fixed_panel_flags() & ~ImGuiWindowFlags_NoBringToFrontOnFocus) |
                   ImGuiWindowFlags_NoBackground);
  ImGui::InvisibleButton("##grip", {6.0f, height});
  widgets::help(Help("Drag to change the width of the panel"));
  if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
    ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  }
  if (ImGui::IsItemActive()) {
    window.panel_width =
        std::clamp((width - ImGui::GetIO().MousePos.x) / em, kMinPanelWidth, kMaxPanelWidth);
  }
  register_window();
  ImGui::End();
  ImGui::PopStyleVar(2);
}

void Interface::draw_dialogs(Workbench& bench) {
  const std::string& scene = bench.load_status().path;
  if (std::exchange(bench.interface.scene_dialog_requested, false)) open_dialog_.open(scene);
  open_dialog_.draw([&](const std::string& path) { bench.files.open_dropped(path); });
  if (std::exchange(bench.interface.environment_dialog_requested, false)) {
    const std::string& now = bench.session.edits().environment.file;
    environment_dialog_.open(now.empty() ? scene : now);
  }
  environment_dialog_.draw([&](const std::string& path) { bench.edits.set_environment(path); });
  if (std::exchange(bench.interface.save_dialog_requested, false)) {
    const std::filesystem::path stem = std::filesystem::path(scene).stem();
    const bool heatmap = bench.session.settings().overlay != ViewOverlay::kNone;
    save_dialog_.open(stem.string() + (heatmap ? "-heatmap.png" : ".exr"));
  }
  save_dialog_.draw([&](const std::string& path) {
    const ViewOverlay overlay = bench.session.settings().overlay;
    if (overlay == ViewOverlay::kNone || path.ends_with(".exr"))
      return bench.files.save_picture(path);
    bench.files.save_heatmap(path, overlay);
  });
}

}  // namespace emberline
