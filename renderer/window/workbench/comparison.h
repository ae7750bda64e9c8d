// Compares two pictures with a wipe, a movable line with a picture on each side. Wipe::kStored
// shows the newest picture, A, and an earlier picture that the user has kept, B. Wipe::kRaw shows
// the denoised and the raw picture.
//
// Used on the window's thread only; nothing here blocks.
#pragma once

#include <memory>

#include "renderer/session/render_session.h"

namespace emberline {

class Workbench;

// Picture B, unchanged since the user kept it.
struct StoredPicture {
  std::shared_ptr<const SessionPicture> picture;  // null if there is none
  DisplaySettings display;                        // display settings when it was kept
  double time_s = 0.0;                            // window_time_s() when it was kept
};

enum class Wipe : uint8_t {
  kNone,
  kStored,  // newest picture on the left, B on the right
  kRaw,     // denoised on the left, raw on the right
};

class Comparison {
 public:
  explicit Comparison(Workbench& bench) : bench_(bench) {}

  // Fetches updates from the session. Call whenever the window wakes up. Returns whether there is
  // something new to display.
  bool update();

  // Keeps `picture` as B. Null is ignored.
  void store(const std::shared_ptr<const SessionPicture>& picture);
  const StoredPicture& stored() const { return stored_; }
  // Returns whether B uses the current display settings instead of those with which it was kept.
  bool graded_as_a() const { return graded_as_a_; }
  void set_graded_as_a(bool on) { graded_as_a_ = on; }
  // Returns B as displayed, or null if no picture is kept.
  const std::shared_ptr<const SessionPicture>& picture_b() const { return picture_b_; }

  Wipe wipe() const { return wipe_; }
  // Switches this kind of wipe on or off, or tells the user why it is not possible.
  void toggle(Wipe kind);
  // Returns the position of the wipe's line as a fraction of the picture's width, in [0, 1].
  float wipe_position() const { return wipe_position_; }
  void set_wipe_position(float wipe_position);

  // Switching denoising off also ends the raw wipe.
  void toggle_denoise();

 private:
  void set_raw_wipe(bool on);

  Workbench& bench_;
  StoredPicture stored_;
  std::shared_ptr<const SessionPicture> picture_b_;
  bool graded_as_a_ = true;
  Wipe wipe_ = Wipe::kNone;
  float wipe_position_ = 0.5f;
};

}  // namespace emberline
