// The status line.
#include <fmt/format.h>
#include <imgui.h>

#include <string>
#include <vector>

#include "renderer/core/readable.h"
#include "renderer/window/panels/label.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"

namespace emberline {
namespace {

// Returns the parts of the status line from left to right: the driver, its progress, its speed.
std::vector<std::string> status(const Workbench& bench) {
  std::vector<std::string> parts;
  if (!bench.picture()) return parts;
  const SessionPicture& p = *bench.picture();
  const uint64_t pixels = uint64_t(p.width) * uint64_t(p.height);
  parts.push_back(bench.session.settings().paused ? "Paused"
                  : p.finished                    ? "Finished"
                                                  : title_case(p.driver));
  if (!p.complete) {
    parts.push_back("First pass " + readable_percent(p.progress.completion));
  }
  if (pixels > 0) {
    const double per_pixel = double(p.samples) / double(pixels);
    parts.push_back(fmt::format("{:.{}f} samples/px", per_pixel, per_pixel < 100.0 ? 1 : 0));
  }
  parts.push_back(readable_seconds(p.elapsed_s));
  if (p.progress.error_estimate) {
    parts.push_back("Error " + readable_number(*p.progress.error_estimate, 2));
  }
  if (p.rendering_s > 0.0 && p.rays > 0) {
    parts.push_back(fmt::format("{:.2f} Mrays/s", 1e-6 * double(p.rays) / p.rendering_s));
  }
  if (const auto latency = bench.latency.newest_s()) {
    parts.push_back(fmt::format("Edit {:.0f} ms", 1e3 * *latency));
  }
  return parts;
}

std::string right_status(const Workbench& bench) {
  std::string text;
  if (bench.edits.solo()) text += "Solo   ";
  const Wipe wipe = bench.comparison.wipe();
  if (wipe != Wipe::kNone) text += wipe == Wipe::kStored ? "A | B   " : "Denoised | raw   ";
  if (const auto& pixel = bench.pixels.cursor_pixel()) {
    text += fmt::format("{}, {}   ", pixel->x, pixel->y);
  }
  if (bench.picture()) {
    text += fmt::format("{} × {}   {:.0f} %", bench.picture()->width, bench.picture()->height,
                        100.0 * bench.placement.zoom() * ImGui::GetIO().DisplayFramebufferScale.x);
  }
  return text;
}

void draw_parts(const Workbench& bench) {
  const std::string right = right_status(bench);
  const float right_x = ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(right.c_str()).x;
  bool first = true;
  for (const std::string& part : status(bench)) {
    if (!first) ImGui::SameLine(0.0f, 1.4f * ImGui::GetFontSize());
    if (ImGui::GetCursorPosX() + ImGui::CalcTextSize(part.c_str()).x > right_x) break;
    ImGui::TextColored(first ? accent_colour() : ImGui::GetStyleColorVec4(ImGuiCol_Text), "%s",
                       part.c_str());
    first = false;
  }
  if (first) ImGui::TextUnformatted("");
  ImGui::SameLine(right_x);
  ImGui::TextColored(muted_colour(), "%s", right.c_str());
}

// Draws the progress of the first pass along the status line's upper edge.
void draw_progress(const Workbench& bench, float top, float width) {
  if (!bench.picture() || bench.picture()->complete) return;
  const auto part = float(bench.picture()->progress.completion);
  ImGui::GetWindowDrawList()->AddRectFilled({0.0f, top}, {width * part, top + 2.0f},
                                            ImGui::GetColorU32(accent_colour()));
}

}  // namespace

void draw_status_line(const Workbench& bench, float width, float height) {
  const float line = ImGui::GetFrameHeight() + 2.0f;
  ImGui::SetNextWindowPos({0.0f, height - line});
  ImGui::SetNextWindowSize({width, line});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.7f * ImGui::GetFontSize(), 1.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1.0f, 1.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImGui::GetStyleColorVec4(ImGuiCol_MenuBarBg));
  ImGui::Begin("##status", nullptr, fixed_panel_flags());
  ImGui::AlignTextToFramePadding();
  draw_parts(bench);
  draw_progress(bench, height - line, width);
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(3);
}

}  // namespace emberline
