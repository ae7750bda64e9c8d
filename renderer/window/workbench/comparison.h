// Two pictures side by side, with a wipe between them: the newest one, A, against one that was kept
// before, B; or the denoised one against the raw one.
//
// The window's thread only; nothing here blocks it.
#pragma once

#include <memory>

#include "renderer/session/render_session.h"

namespace emberline {

class Workbench;

// B, as it was kept.
struct KeptPicture {
  std::shared_ptr<const ShownPicture> picture;  // null: none
  DisplaySettings display;                      // of that moment
  double time_s = 0.0;                          // when it was kept; window_time_s()
};

enum class Wipe : uint8_t {
  kNone,
  kKept,  // the newest picture to the left, B to the right
  kRaw,   // denoised to the left, raw to the right
};

class Comparison {
 public:
  explicit Comparison(Workbench& bench) : bench_(bench) {}

  // Takes in what the session has brought. Called each time that the window wakes up. True if
  // there is something new to be seen.
  bool update();

  // Null: there is nothing to keep.
  void keep(const std::shared_ptr<const ShownPicture>& picture);
  const KeptPicture& kept() const { return kept_; }
  // Whether B has the display settings of now; else it has those that it was kept with.
  bool graded_as_a() const { return graded_as_a_; }
  void grade_as_a(bool on) { graded_as_a_ = on; }
  // B as it is to be shown; null if nothing is kept.
  const std::shared_ptr<const ShownPicture>& picture_b() const { return picture_b_; }

  Wipe wipe() const { return wipe_; }
  // Switches this kind of wipe on or off, or tells the user why there is none.
  void toggle(Wipe kind);
  // Share of the picture's width that lies to the left of the wipe, in [0, 1].
  float place() const { return place_; }
  void move_to(float place);

  // Without denoised pictures there is no wipe between them and raw ones.
  void toggle_denoise();

 private:
  void set_raw_wipe(bool on);

  Workbench& bench_;
  KeptPicture kept_;
  std::shared_ptr<const ShownPicture> picture_b_;
  bool graded_as_a_ = true;
  Wipe wipe_ = Wipe::kNone;
  float place_ = 0.5f;
};

}  // namespace emberline
