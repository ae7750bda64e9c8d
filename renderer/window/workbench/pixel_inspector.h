// Single pixels of the picture: the one under the cursor, and the one that was clicked, whose
// samples are explained. Values that the session has to wait for arrive with update().
//
// The window's thread only; nothing here blocks it.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "renderer/session/shown_picture.h"

namespace emberline {

class Workbench;

// The material whose panel is open.
struct MaterialSelection {
  int material = -1;      // into ListedScene::outline's materials; -1: none
  bool show_tab = false;  // the tab of materials is to be opened
};

class PixelInspector {
 public:
  // `copy_text` puts a text on the clipboard.
  PixelInspector(Workbench& bench, std::function<void(const std::string&)> copy_text)
      : bench_(bench), copy_text_(std::move(copy_text)) {}

  // The session has a new scene.
  void scene_arrived();
  // Takes in what the session has brought. Called each time that the window wakes up. True if
  // there is something new to be seen.
  bool update();

  // The cursor is over this pixel; none: beside the picture.
  void point_at(const std::optional<Vec2i>& pixel);
  const std::optional<Vec2i>& pointed() const { return pointed_; }
  // The inspected pixel, if a panel asks for it.
  const std::optional<PixelInspection>& inspection() const { return inspection_; }
  // Shows it beside the cursor, or not (WindowState::inspector).
  void toggle();
  void copy_values();

  // A click: selects the material there, and picks the pixel to be explained.
  void select_at(const Vec2i& pixel);
  // A double click: the camera orbits around what is seen there.
  void orbit_around(const Vec2i& pixel);

  // The pixel that was clicked last.
  const std::optional<Vec2i>& picked() const { return picked_; }
  // Whether the panel with its explanation is open. It opens with the pixel under the cursor, or
  // else with the one of before.
  bool explains() const { return explains_; }
  void toggle_explanation();
  const std::optional<PixelInspection>& explanation() const { return explanation_; }
  // As the panel shows it; empty while nothing is known.
  std::string explanation_text() const;
  void copy_explanation();

 private:
  bool refresh_inspection();
  bool refresh_explanation();
  void serve_clicks();

  Workbench& bench_;
  const std::function<void(const std::string&)> copy_text_;
  std::optional<Vec2i> pointed_, picked_;
  std::optional<Vec2i> clicked_, pivot_;  // until it is known what is there
  bool explains_ = false;
  std::optional<PixelInspection> inspection_, explanation_;
};

}  // namespace emberline
