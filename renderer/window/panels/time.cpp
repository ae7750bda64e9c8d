// The time line under the picture, for scenes with animations.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <optional>

#include "renderer/window/panels/action_widgets.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/time_line.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

using Animations = std::vector<AnimationDescription>;

constexpr double kMinFps = 1.0, kMaxFps = 240.0;
constexpr double kDefaultShutter = 0.5;  // in frames; a shutter angle of 180 degrees

std::string display_name(const AnimationEdit& edit, const Animations& list) {
  if (is_unanimated(edit)) return "No Animation";
  const int index = animation_index(edit, list);
  if (index < 0) return "All";
  const std::string& name = list[size_t(index)].name;
  return name.empty() ? fmt::format("Animation {}", index) : name;
}

bool choose_animation(AnimationEdit& edit, const Animations& list) {
  const AnimationEdit before = edit;
  ImGui::SetNextItemWidth(9.0f * ImGui::GetFontSize());
  if (!widgets::begin_list("##animation", "Animation to play", display_name(edit, list)))
    return false;
  const auto offer = [&](const std::string& label, const std::string& name, bool at_rest) {
    if (!ImGui::Selectable(label.c_str())) return;
    edit.name = name;
    edit.time = at_rest ? std::nullopt : std::optional(edit.time.value_or(0.0));
  };
  offer("No Animation", "", true);
  for (size_t i = 0; i < list.size(); ++i) {
    ImGui::PushID(int(i));
    const std::string name = animation_name(i, list);
    offer(display_name({.name = name, .time = 0.0}, list), name, false);
    ImGui::PopID();
  }
  if (list.size() > 1) offer("All", "all", false);
  ImGui::EndCombo();
  return edit != before;
}

bool choose_fps(AnimationEdit& edit) {
  double fps = fps_of(edit);
  ImGui::SetNextItemWidth(5.0f * ImGui::GetFontSize());
  if (!widgets::drag_bare("##fps", "Frames per second", fps, 0.1, kMinFps, kMaxFps, "%.5g fps")) {
    return false;
  }
  edit.fps = fps;
  return true;
}

bool choose_shutter(AnimationEdit& edit) {
  bool open = edit.shutter_open.has_value();
  bool changed = widgets::checkbox(
      "Shutter", "Use motion blur: objects that move while the shutter is open are blurred", open);
  if (changed) {
    edit.shutter_open = open ? std::optional(0.0) : std::nullopt;
    edit.shutter_close = open ? std::optional(kDefaultShutter) : std::nullopt;
  }
  if (!open) return changed;
  float ends[2] = {float(*edit.shutter_open), float(*edit.shutter_close)};
  ImGui::SameLine();
  ImGui::SetNextItemWidth(8.0f * ImGui::GetFontSize());
  if (widgets::drag_pair("##shutter", "When the shutter opens and closes, in frames", ends, 0.01f,
                         -1.0f, 2.0f, "%.2f")) {
    edit.shutter_open = double(ends[0]);
    edit.shutter_close = double(std::max(ends[0], ends[1]));
    changed = true;
  }
  ImGui::SameLine();
  ImGui::Text("%.0f°", 360.0 * (*edit.shutter_close - *edit.shutter_open));
  return changed;
}

// Draws the slider for the time, which fills the rest of the line except for `reserved_width`.
bool scrub(AnimationEdit& edit, double duration, float reserved_width) {
  const double fps = fps_of(edit);
  double time = edit.time.value_or(0.0);
  const std::string text =
      fmt::format("{:.2f} s of {:.2f} s   Frame {:.0f}", time, duration, frame_at(time, fps));
  ImGui::SetNextItemWidth(std::max(ImGui::GetContentRegionAvail().x - reserved_width, 60.0f));
  if (!widgets::slide_bare("##time", "Time of the animation", time, duration, text.c_str())) {
    return false;
  }
  edit.time = time;
  return true;
}

}  // namespace

float time_line_height(const Workbench& bench) {
  return bench.player.available() ? 2.0f * ImGui::GetFrameHeightWithSpacing() + 4.0f : 0.0f;
}

void draw_time_line(Workbench& bench, float top, float width) {
  if (!bench.player.available()) return;
  const Animations& list = bench.session.scene()->animations;
  ImGui::SetNextWindowPos({0.0f, top});
  ImGui::SetNextWindowSize({width, time_line_height(bench)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.7f * ImGui::GetFontSize(), 2.0f));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
  ImGui::Begin("##time line", nullptr, fixed_panel_flags());
  AnimationEdit edit = bench.session.edits().animation;
  action_button(bench, bench.player.playing() ? "Stop" : "Play", Action::kPlay);
  ImGui::SameLine();
  action_button(bench, "<", Action::kPreviousFrame);
  ImGui::SameLine();
  action_button(bench, ">", Action::kNextFrame);
  ImGui::SameLine();
  if (scrub(edit, duration_of(edit, list), 0.0f)) {
    bench.player.stop();
    bench.edits.change(edit, "time");
  }
  bool changed = choose_animation(edit, list);
  ImGui::SameLine();
  changed |= choose_fps(edit);
  ImGui::SameLine();
  bool loop = bench.player.is_looping();
  if (widgets::checkbox("Loop", "Start again at the end of the animation", loop)) {
    bench.player.set_loop(loop);
  }
  ImGui::SameLine();
  changed |= choose_shutter(edit);
  if (changed) bench.edits.change(edit, "animation");
  ImGui::End();
  ImGui::PopStyleVar(2);
}

}  // namespace emberline
