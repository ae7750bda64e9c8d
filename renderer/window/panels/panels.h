// The interface around the picture. Each function draws a part of it and applies the user's changes
// to the workbench. Call these functions between ImGui's NewFrame and Render.
#pragma once

#include <vector>

#include "renderer/core/rect.h"
#include "renderer/window/panels/file_dialog.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

// Draws the menu, tabs, status line and dialogs, and places the picture in the rest of the window.
class Interface {
 public:
  void draw(Workbench& bench, float width, float height);
  // Returns whether a panel, menu or dialog covers the point.
  bool covers(const Vec2f& point) const;
  bool popup_open() const { return is_popup_open_; }  // a menu, list or dialog has keyboard focus
  const char* focused_dialog() const;  // the dialog whose name field has focus; empty if none
  void cancel_dialogs();               // does the same as their Cancel buttons

 private:
  void draw_side_panel(Workbench& bench, float top, float width, float bottom);
  void draw_panel_edge(WindowState& window, float top, float width, float height);
  void draw_shortcuts(Workbench& bench);
  void draw_messages(Workbench& bench);
  void draw_explanation(Workbench& bench);
  void draw_notice(Workbench& bench);
  void draw_loading(Workbench& bench);
  void draw_welcome(Workbench& bench);
  void draw_dialogs(Workbench& bench);
  void register_window();  // registers the ImGui window being drawn, for covers()

  FileDialog open_dialog_{
      "Open File", "Open", FileDialog::Purpose::kRead, {".gltf", ".glb", ".hdr", ".exr", ".json"}};
  FileDialog environment_dialog_{
      "Choose Environment", "Choose", FileDialog::Purpose::kRead, {".hdr", ".exr"}};
  FileDialog save_dialog_{
      "Save Picture", "Save", FileDialog::Purpose::kWrite, {".exr", ".png", ".jpg", ".jpeg"}};
  std::vector<Rect> floating_windows_;
  bool is_popup_open_ = false;
  bool is_tab_restored_ = false;
  double dismissed_s_ = 0.0;  // messages before this time are not shown over the picture
};

// Draw the contents of the tabs.
void draw_lights(Workbench& bench);
void draw_materials(Workbench& bench);
void draw_camera(Workbench& bench);
void draw_sampling(Workbench& bench);
void draw_display(Workbench& bench);

// Draw along the upper and lower edges of the window.
void draw_menu(Workbench& bench);
void draw_status_line(const Workbench& bench, float width, float height);

// Draws the time line under the picture. If the scene has no animations, there is no time line, and
// the height is 0.
float time_line_height(const Workbench& bench);
void draw_time_line(Workbench& bench, float top, float width);

}  // namespace emberline
