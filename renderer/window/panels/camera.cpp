// The camera tab.
#include <fmt/format.h>
#include <imgui.h>

#include <array>
#include <numbers>

#include "renderer/core/errors.h"
#include "renderer/window/panels/action_widgets.h"
#include "renderer/window/panels/choose_target.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"

namespace emberline {
namespace {

constexpr double kDefaultFStop = 2.8;  // used when the user switches a lens on
constexpr float kMinHeight = 1e-3f,
                kMaxHeight = 100.0f;  // orthographic height, relative to the scene's radius

void choose_file_camera(Workbench& bench) {
  const auto& cameras = bench.session.scene()->outline.cameras;
  if (cameras.empty()) return;
  const CameraEdit& now = bench.session.edits().camera;
  CameraEdit edit;
  edit.camera = now.camera;
  if (choose_target({"File Camera", "A camera defined in the scene's file"}, edit.camera, cameras,
                    "Camera", "Initial", now.look_from ? "Free" : "")) {
    const auto index = edit.camera ? find_entry(*edit.camera, cameras) : std::nullopt;
    if (index && cameras[*index].fault) {
      return bench.messages.error(cameras[*index].fault->what());
    }
    bench.edits.change(edit, "file camera");
  }
}

void choose_projection(Workbench& bench, const CameraDescription& view_camera) {
  const std::array choices = {
      widgets::Choice{"perspective", "Perspective", "Distant objects look smaller"},
      widgets::Choice{"orthographic", "Orthographic",
                      "Objects look the same size at any distance; there is no depth of field"}};
  int index = view_camera.orthographic ? 1 : 0;
  if (widgets::choose_index(
          {"Projection",
           "How the camera projects the scene. After a change, the object that the "
           "camera orbits keeps its size."},
          index, choices)) {
    bench.navigator.set_orthographic(index == 1);
  }
}

void slide_fov(Workbench& bench, const CameraDescription& view_camera) {
  CameraEdit edit = bench.session.edits().camera;
  if (widgets::slide_edit("Field of View", "Vertical angle of view", edit.fov_y_degrees,
                          view_camera.fov_y * 180.0 / std::numbers::pi, 1.0f, 150.0f, "%.1f°")) {
    bench.edits.change(edit, "field of view");
  }
}

// Offers no reset to the file's value, because the file's camera has no height unless it is
// orthographic.
void slide_height(Workbench& bench, const CameraDescription& view_camera) {
  const auto radius = float(bench.session.scene()->radius);
  CameraEdit edit = bench.session.edits().camera;
  auto height = float(2.0 * view_camera.y_mag);
  if (widgets::slide(
          {"Height", "Height of the view in metres", edit.orthographic_height.has_value()}, height,
          kMinHeight * radius, kMaxHeight * radius, "%.4g m", true)) {
    edit.orthographic_height = double(height);
    bench.edits.change(edit, "height");
  }
}

void draw_lens(Workbench& bench) {
  CameraEdit edit = bench.session.edits().camera;
  bool lens = edit.f_stop.has_value();
  if (widgets::check({"Lens", "Use depth of field. Without a lens everything is sharp."}, lens)) {
    edit.f_stop = lens ? std::optional<double>(kDefaultFStop) : std::nullopt;
    edit.focus_distance =
        lens ? std::optional<double>(bench.navigator.focus_distance()) : std::nullopt;
    bench.edits.change(edit, "lens");
  }
  if (!edit.f_stop) return;
  auto stop = float(*edit.f_stop);
  if (widgets::slide({"Aperture", "F-number. A smaller number is a larger opening and blurs more."},
                     stop, 0.5f, 64.0f, "f/%.2g", true)) {
    edit.f_stop = double(stop);
    bench.edits.change(edit, "aperture");
  }
  auto focus = float(bench.navigator.focus_distance());
  const auto radius = float(bench.session.scene()->radius);
  if (widgets::slide(
          {"Focus",
           "Distance of the sharp plane in metres. Double-click on the picture to focus there."},
          focus, 0.01f * radius, 20.0f * radius, "%.3g m", true)) {
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
                          stored ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : muted_colour());
    const bool pressed =
        widgets::button(std::to_string(i).c_str(),
                        stored ? Help("Go to this bookmark. Ctrl+click to store the view here.")
                               : Help("Store the view as this bookmark"),
                        side);
    ImGui::PopStyleColor();
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
  const CameraDescription view_camera =
      edited_camera(edits, bench.session.scene()->outline, bench.session.scene()->camera);
  choose_projection(bench, view_camera);
  if (view_camera.orthographic) {
    slide_height(bench, view_camera);
  } else {
    slide_fov(bench, view_camera);
    draw_lens(bench);
  }
  bool mirrored = view_camera.to_world.determinant() < 0;
  if (widgets::check({"Mirrored", "Flip the picture horizontally"}, mirrored)) {
    bench.navigator.set_mirrored(mirrored);
  }
  const auto& m = view_camera.to_world;
  widgets::text({"Position", "Position of the camera in metres"},
                fmt::format("{:.4g}  {:.4g}  {:.4g}", m[3][0], m[3][1], m[3][2]));
  widgets::text({"Direction", "Viewing direction of the camera"},
                fmt::format("{:.3f}  {:.3f}  {:.3f}", -m[2][0], -m[2][1], -m[2][2]));

  const float half = widgets::half_width();
  action_button(bench, "Frame All", Action::kFrameAll, half);
  ImGui::SameLine();
  action_button(bench, "Reset", Action::kResetCamera, half);
  widgets::heading("Bookmarks");
  draw_bookmarks(bench);
}

}  // namespace emberline
