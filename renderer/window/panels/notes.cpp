// Notes over the picture: the welcome, loading progress, messages.
#include <imgui.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "renderer/window/panels/action_widgets.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"
#include "renderer/window/workbench/clock.h"

namespace emberline {
namespace {

constexpr double kNoticeTime_s = 6.0, kErrorTime_s = 60.0;
constexpr ImGuiWindowFlags kNote =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoMove;

ImVec4 level_colour(Message::Level level) {
  if (level == Message::Level::kError) return error_colour();
  if (level == Message::Level::kWarning) return warning_colour();
  return ImGui::GetStyleColorVec4(ImGuiCol_Text);
}

void draw_message_text(const Message& message) {
  ImGui::PushStyleColor(ImGuiCol_Text, level_colour(message.level));
  ImGui::TextUnformatted(message.text.c_str());
  ImGui::PopStyleColor();
}

// `height` is the vertical position in the area, from 0 at the top to 1 at the bottom.
void center_next_window(const Rect& area, float height) {
  const float y = float(area.y0) + height * float(area.height());
  ImGui::SetNextWindowPos({0.5f * float(area.x0 + area.x1), y}, ImGuiCond_Always, {0.5f, 0.5f});
}

}  // namespace

void Interface::draw_welcome(Workbench& bench) {
  if (bench.session.scene() || bench.load_status().state == LoadStatus::State::kLoading) return;
  center_next_window(bench.placement.area(), 0.45f);
  ImGui::Begin("##welcome", nullptr, kNote);
  ImGui::TextUnformatted("Drop a .gltf or .glb file here");
  action_button(bench, "Open Scene…", Action::kOpen, -1.0f);
  const std::vector<std::string>& recent = bench.window.recent_scenes;
  if (!recent.empty()) widgets::heading("Recent");
  for (const std::string& scene : recent) {
    if (ImGui::Selectable(std::filesystem::path(scene).filename().string().c_str())) {
      bench.files.open(scene);
    }
    widgets::help(scene);
  }
  register_window();
  ImGui::End();
}

void Interface::draw_loading(Workbench& bench) {
  const LoadStatus& status = bench.load_status();
  if (status.state != LoadStatus::State::kLoading) return;
  const float em = ImGui::GetFontSize();
  center_next_window(bench.placement.area(), 0.5f);
  ImGui::Begin("##loading", nullptr, kNote);
  const std::string name = std::filesystem::path(status.path).filename().string();
  ImGui::Text("Loading %s", name.c_str());
  ImGui::ProgressBar(float(status.fraction), {22.0f * em, 0.4f * em}, "");
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(muted_colour(), "%s", sentence_case(status.stage).c_str());
  ImGui::SameLine(16.0f * em);
  if (widgets::button("Cancel", "Stop loading the scene",
                      6.0f * em + ImGui::GetStyle().WindowPadding.x)) {
    bench.session.cancel_load();
  }
  register_window();
  ImGui::End();
}

// Shows the newest message over the picture's lower edge for a while; errors stay longer.
void Interface::draw_notice(Workbench& bench) {
  const std::deque<Message>& messages = bench.messages.messages();
  if (messages.empty()) return;
  const Message& message = messages.back();
  const bool error = message.level == Message::Level::kError;
  const double age = window_time_s() - message.time_s;
  if (message.time_s <= dismissed_s_ || age > (error ? kErrorTime_s : kNoticeTime_s)) return;
  const Rect& area = bench.placement.area();
  const float em = ImGui::GetFontSize();
  ImGui::SetNextWindowPos({float(area.x0) + em, float(area.y1) - em}, ImGuiCond_Always,
                          {0.0f, 1.0f});
  ImGui::SetNextWindowBgAlpha(0.92f);
  ImGui::Begin("##notice", nullptr, kNote);
  ImGui::PushTextWrapPos(std::min(48.0f * em, float(area.width()) - 6.0f * em));
  draw_message_text(message);
  ImGui::PopTextWrapPos();
  if (message.level != Message::Level::kNote) {
    if (widgets::small_button("Close", "Hide this message")) dismissed_s_ = message.time_s;
    ImGui::SameLine();
    if (widgets::small_button("All Messages", "Show all messages so far (F2)")) {
      bench.interface.show_messages = true;
    }
  }
  register_window();
  ImGui::End();
}

void Interface::draw_messages(Workbench& bench) {
  if (!bench.interface.show_messages) return;
  const float em = ImGui::GetFontSize();
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({2.0f * em, screen.y - 3.0f * em}, ImGuiCond_Appearing, {0.0f, 1.0f});
  ImGui::SetNextWindowSize(
      {std::min(52.0f * em, 0.9f * screen.x), std::min(16.0f * em, 0.6f * screen.y)},
      ImGuiCond_Appearing);
  if (ImGui::Begin("Messages", &bench.interface.show_messages, ImGuiWindowFlags_NoSavedSettings)) {
    ImGui::PushTextWrapPos(0.0f);
    const std::deque<Message>& messages = bench.messages.messages();
    for (const Message& message : messages) {
      ImGui::TextColored(muted_colour(), "%7.1f s", message.time_s);
      ImGui::SameLine();
      draw_message_text(message);
    }
    ImGui::PopTextWrapPos();
    if (messages.empty()) ImGui::TextColored(muted_colour(), "There are no messages yet.");
    if (ImGui::GetScrollY() >= ImGui::GetScrollMaxY()) ImGui::SetScrollHereY(1.0f);
  }
  register_window();
  ImGui::End();
}

}  // namespace emberline
