// Shows the driver's explanation of how many samples a pixel got.
#include <imgui.h>

#include <algorithm>

#include "renderer/session/prepared_settings.h"
#include "renderer/window/panels/action_widgets.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

// Size in line heights. The driver's tables are 80 characters wide.
constexpr float kWidth = 44.0f, kHeight = 22.0f;

// Places the panel in the corner of the picture area farthest from the pixel, and leaves space for
// notes at the lower edge.
void place_opposite_pixel(const Workbench& bench) {
  const float em = ImGui::GetFontSize();
  const Rect& area = bench.placement.area();
  const auto& pixel = bench.pixels.picked();
  const Vec2f at =
      bench.placement.to_screen(pixel ? Vec2f(float(pixel->x), float(pixel->y)) : Vec2f(0.0f));
  const bool left = at.x > 0.5f * float(area.x0 + area.x1);
  const bool above = at.y > 0.5f * float(area.y0 + area.y1);
  ImGui::SetNextWindowPos({left ? float(area.x0) + em : float(area.x1) - em,
                           above ? float(area.y0) + em : float(area.y1) - 3.5f * em},
                          ImGuiCond_Appearing, {left ? 0.0f : 1.0f, above ? 0.0f : 1.0f});
}

void draw_text(const Workbench& bench) {
  const std::string text = bench.pixels.explanation_text();
  if (!bench.pixels.picked()) {
    widgets::muted_paragraph("Click on the picture to choose a pixel.");
  } else if (text.empty()) {
    widgets::muted_paragraph("Waiting for the first samples of this pixel.");
  } else if (bench.pixels.explanation()->explanation.empty() &&
             is_live(bench.session.settings().render)) {
    widgets::muted_paragraph(
        "Every pixel has one sample so far. After the first picture, the driver chooses the number "
        "for each pixel.");
  } else if (bench.pixels.explanation()->explanation.empty()) {
    widgets::muted_paragraph(
        "This driver gives every pixel the same number of samples. The adaptive driver chooses the "
        "number for each pixel.");
  }
  ImGui::PushFont(fixed_font());
  ImGui::TextUnformatted(text.c_str(), text.c_str() + text.size());
  ImGui::PopFont();
}

}  // namespace

// The panel keeps its position when its text or the pixel changes.
void Interface::draw_explanation(Workbench& bench) {
  if (!bench.pixels.shows_explanation()) return;
  const float em = ImGui::GetFontSize();
  const Rect& area = bench.placement.area();
  place_opposite_pixel(bench);
  ImGui::SetNextWindowSize({std::min(kWidth * em, float(area.width()) - 2.0f * em),
                            std::min(kHeight * em, 0.7f * float(area.height()))},
                           ImGuiCond_Appearing);
  bool open = true;
  if (ImGui::Begin("Explain Pixel", &open, ImGuiWindowFlags_NoSavedSettings)) {
    const float buttons = ImGui::GetFrameHeightWithSpacing();
    ImGui::BeginChild("##text", {0.0f, -buttons}, false, ImGuiWindowFlags_HorizontalScrollbar);
    draw_text(bench);
    ImGui::EndChild();
    ImGui::BeginDisabled(bench.pixels.explanation_text().empty());
    if (widgets::button("Copy", "Copy the explanation")) bench.pixels.copy_explanation();
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (widgets::button("Restart",
                        "Restart rendering and record this pixel from its first sample (F5)")) {
      bench.act(Action::kRestart);
    }
  }
  register_window();
  ImGui::End();
  if (!open) bench.act(Action::kExplain);
}

}  // namespace emberline
