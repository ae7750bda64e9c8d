#include "renderer/window/workbench/comparison.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/window/workbench/clock.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

bool Comparison::update() {
  bench_.session.compare_with(graded_as_a_ ? stored_.picture : nullptr);
  std::shared_ptr<const SessionPicture> graded =
      graded_as_a_ ? bench_.session.graded_comparison() : nullptr;
  std::shared_ptr<const SessionPicture> picture = graded ? std::move(graded) : stored_.picture;
  if (picture == picture_b_) return false;
  picture_b_ = std::move(picture);
  if (bench_.journal.is_open()) {
    bench_.journal.write("kept", {{"serial", picture_b_->serial}, {"graded_as_a", graded_as_a_}});
  }
  return true;
}

void Comparison::store(const std::shared_ptr<const SessionPicture>& picture) {
  if (!picture) return;
  stored_ = {picture, bench_.session.settings().display, window_time_s()};
  bench_.messages.note("Kept the picture as B. Press V to wipe between A and B.");
}

void Comparison::toggle(Wipe kind) {
  if (kind == Wipe::kRaw) return set_raw_wipe(wipe_ != Wipe::kRaw);
  if (!stored_.picture)
    return bench_.messages.note("There is no picture to compare with. Press B to keep one.");
  const bool on = wipe_ != Wipe::kStored;
  set_raw_wipe(false);
  wipe_ = on ? Wipe::kStored : Wipe::kNone;
}

void Comparison::set_raw_wipe(bool on) {
  if (on && !bench_.session.settings().denoise) {
    return bench_.messages.note("Denoising is off. Press N to turn it on.");
  }
  if (on == (wipe_ == Wipe::kRaw)) return;
  wipe_ = on ? Wipe::kRaw : Wipe::kNone;
  bench_.settings.change_with([&](ViewSettings& s) { s.include_raw = on; });
}

void Comparison::set_wipe_position(float wipe_position) {
  wipe_position_ = std::clamp(wipe_position, 0.0f, 1.0f);
}

void Comparison::toggle_denoise() {
  const bool on = !bench_.session.settings().denoise;
  if (!on) set_raw_wipe(false);
  bench_.settings.change_with([&](ViewSettings& s) { s.denoise = on; });
}

}  // namespace emberline
