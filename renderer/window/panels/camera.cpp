// The camera tab.
#include <fmt/format.h>
#include <imgui.h>

#include <array>
#include <numbers>

#include "renderer/core/errors.h"
#include "renderer/window/panels/choose_target.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

constexpr double kFirstStop = 2.8;  // default when a lens is switched on
constexpr float kLeastHeight = 1e-3f,
                kMostHeight = 100.0f;  // orthographic, relative to the scene's radius

void choose_file_camera(Workbench& bench) {
  const auto& cameras = bench.session.scene()->outline.cameras;
  if (cameras.empty()) return;
  const CameraEdit& now = bench.session.edits().camera;
  CameraEdit edit;
  edit.camera = now.camera;
  if (choose_target({"File camera"}, edit.camera, cameras, "camera", "as opened",
                    now.look_from ? "free" : "")) {
    const auto index = edit.camera ? find_entry(*edit.camera, cameras) : std::nullopt;
    if (index && cameras[*index].fault) {
      return bench.messages.error(cameras[*index].fault->what());
    }
    bench.edits.change(edit, "file camera");
  }
}

void choose_projection(Workbench& bench, const CameraDescription& seen) {
  constexpr std::array kChoices = {
      widgets::Choice{"perspective", "what is farther away is smaller"},
      widgets::Choice{"orthographic", "sizes do not depend on the distance; without a lens"}};
  int index = seen.orthographic ? 1 : 0;
  if (widgets::choose_index({"Projection", "what is orbited keeps its size on a change"}, index,
                            kChoices)) {
    bench.navigator.set_orthographic(index == 1);
  }
}

void slide_fov(Workbench& bench, const CameraDescription& seen) {
  CameraEdit edit = bench.session.edits().camera;
  if (widgets::slide_edit("Field of view", "vertical", edit.fov_y_degrees,
                          seen.fov_y * 180.0 / std::numbers::pi, 1.0f, 150.0f, "%.1f°")) {
    bench.edits.change(edit, "field of view");
  }
}

// Has no reset to the file's value, since only some cameras have a height.
void slide_height(Workbench& bench, const CameraDescription& seen) {
  const auto radius = float(bench.session.scene()->radius);
  CameraEdit edit = bench.session.edits().camera;
  auto height = float(2.0 * seen.y_mag);
  if (widgets::slide({"Height", "metres from the picture's lower edge to its upper one",
                      edit.orthographic_height.has_value()},
                     height, kLeastHeight * radius, kMostHeight * radius, "%.4g m", true)) {
    edit.orthographic_height = double(height);
    bench.edits.change(edit, "height");
  }
}

void draw_lens(Workbench& bench) {
  CameraEdit edit = bench.session.edits().camera;
  bool lens = edit.f_stop.has_value();
  if (widgets::check({"Lens", "depth of field; else a pinhole, and all is sharp"}, lens)) {
    edit.f_stop = lens ? std::optional<double>(kFirstStop) : std::nullopt;
    edit.focus_distance =
        lens ? std::optional<double>(bench.navigator.focus_distance()) : std::nullopt;
    bench.edits.change(edit, "lens");
  }
  if (!edit.f_stop) return;
  auto stop = float(*edit.f_stop);
  if (widgets::slide({"Aperture", "a smaller number is a larger opening, and less is sharp"}, stop,
                     0.5f, 64.0f, "f/%.2g", true)) {
    edit.f_stop = double(stop);
    bench.edits.change(edit, "aperture");
  }
  auto focus = float(bench.navigator.focus_distance());
  const auto radius = float(bench.session.scene()->radius);
  if (widgets::slide({"Focus", "metres; a double click on the picture focuses there"}, focus,
                     0.01f * radius, 20.0f * radius, "%.3g m", true)) {
    edit.focus_distance = double(focus);
    bench.edits.change(edit, "focus");
  }
}

void draw_bookmarks(Workbench& bench) {
  const float spacing = 0.5f * ImGui::GetStyle().ItemInnerSpacing.x;
  const float side = (ImGui::GetContentRegionAvail().x - 8.0f * spacing) / 9.0f;
  for (int i = 1; i <= 9; ++i) {
    const bool stored = bench.navigator.bookmarks()[size_t(i - 1)].has_value();
    if (i > 1) ImGui::SameLine(0.0f, spacing);
    ImGui::PushStyleColor(ImGuiCol_Text,
                          stored ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : quiet_colour());
    const bool pressed = ImGui::Button(std::to_string(i).c_str(), {side, 0.0f});
    ImGui::PopStyleColor();
    widgets::help(stored ? "go there; Ctrl+click stores the view in its place"
                         : "empty; a click stores the view");
    if (pressed) {
      const bool store = !stored || ImGui::GetIO().KeyCtrl;
      bench.act(store ? Action::kStoreBookmark : Action::kRecallBookmark, i);
    }
  }
}

}  // namespace

void draw_camera(Workbench& bench) {
  if (!bench.session.scene()) return;
  choose_file_camera(bench);
  const SceneEdits& edits = bench.session.edits();
  const CameraDescription seen =
      edited_camera(edits, bench.session.scene()->outline, bench.session.scene()->camera);
  choose_projection(bench, seen);
  if (seen.orthographic) {
    slide_height(bench, seen);
  } else {
    slide_fov(bench, seen);
    draw_lens(bench);
  }
  bool mirrored = seen.to_world.determinant() < 0;
  if (widgets::check({"Mirrored", "left and right exchanged"}, mirrored)) {
    bench.navigator.set_mirrored(mirrored);
  }
  const auto& m = seen.to_world;
  widgets::text({"Position"}, fmt::format("{:.4g}  {:.4g}  {:.4g}", m[3][0], m[3][1], m[3][2]));
  widgets::text({"Direction"}, fmt::format("{:.3f}  {:.3f}  {:.3f}", -m[2][0], -m[2][1], -m[2][2]));

  const float half = widgets::half_width();
  if (ImGui::Button("Frame all", {half, 0.0f})) bench.act(Action::kFrameAll);
  ImGui::SameLine();
  if (ImGui::Button("Reset", {half, 0.0f})) bench.act(Action::kResetCamera);
  widgets::heading("Bookmarks");
  draw_bookmarks(bench);
}

}  // namespace emberline
