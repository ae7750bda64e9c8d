// Inspects the pixel under the cursor, and the clicked pixel, whose samples are explained. Values
// that are not available immediately arrive later, with update().
//
// Used on the window's thread only; nothing here blocks.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "renderer/session/session_picture.h"

namespace emberline {

class Workbench;

// The material that the materials tab shows.
struct MaterialSelection {
  int material = -1;      // index in the materials of ListedScene::outline; -1 if there is none
  bool show_tab = false;  // request to open the materials tab
};

class PixelInspector {
 public:
  // `copy_text` copies a text to the clipboard.
  PixelInspector(Workbench& bench, std::function<void(const std::string&)> copy_text)
      : bench_(bench), copy_text_(std::move(copy_text)) {}

  void on_new_scene();
  // Fetches updates from the session. Call whenever the window wakes up. Returns whether there is
  // something new to display.
  bool update();

  // Sets the pixel under the cursor, or nullopt if the cursor is outside the picture.
  void set_cursor_pixel(const std::optional<Vec2i>& pixel);
  const std::optional<Vec2i>& cursor_pixel() const { return cursor_pixel_; }
  // Returns the inspection of the pixel under the cursor, or nullopt while neither the display nor
  // a click needs it.
  const std::optional<PixelInspection>& inspection() const { return inspection_; }
  // Toggles the display beside the cursor (WindowState::inspector).
  void toggle();
  void copy_values();

  // Handles a click: selects the material there, and picks the pixel to explain.
  void select_at(const Vec2i& pixel);
  // Handles a double click: makes the point that is visible in this pixel the camera's pivot.
  void orbit_around(const Vec2i& pixel);

  // Returns the pixel to explain: the pixel that was clicked last or that toggle_explanation()
  // chose.
  const std::optional<Vec2i>& picked() const { return picked_; }
  // Returns whether the explanation panel is open. It opens for the pixel under the cursor or, if
  // the cursor is not over the picture, for the pixel picked before.
  bool shows_explanation() const { return shows_explanation_; }
  void toggle_explanation();
  const std::optional<PixelInspection>& explanation() const { return explanation_; }
  // Returns the text in the panel, which is empty if nothing is known.
  std::string explanation_text() const;
  void copy_explanation();

 private:
  bool refresh_inspection();
  bool refresh_explanation();
  void handle_clicks();

  Workbench& bench_;
  const std::function<void(const std::string&)> copy_text_;
  std::optional<Vec2i> cursor_pixel_, picked_;
  std::optional<Vec2i> clicked_, pivot_;  // pending clicks, on pixels that are not inspected yet
  bool shows_explanation_ = false;
  std::optional<PixelInspection> inspection_, explanation_;
};

}  // namespace emberline
