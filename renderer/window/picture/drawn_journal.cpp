#include "renderer/window/picture/drawn_journal.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace emberline {

void DrawnJournal::record_picture(const std::shared_ptr<const SessionPicture>& picture,
                                  const PicturePlacement& placement) {
  if (!journal_.is_open()) return;
  const Vec2f corner = placement.to_screen(Vec2f(0.0f));
  const nlohmann::json place = {{"at", {corner.x, corner.y}}, {"zoom", placement.zoom()}};
  if (corner != corner_ || placement.zoom() != zoom_) journal_.write("placed", place);
  corner_ = corner;
  zoom_ = placement.zoom();
  if (picture == picture_) return;
  picture_ = picture;
  nlohmann::json members = {{"edit", picture->edit},
                            {"serial", picture->serial},
                            {"size", {picture->width, picture->height}},
                            {"filled", picture->filled},
                            {"complete", picture->complete},
                            {"finished", picture->finished},
                            {"samples", picture->samples},
                            {"driver", picture->driver},
                            {"buckets", picture->in_progress.size()},
                            {"denoised", !picture->denoised.empty()},
                            {"legend", picture->overlay_legend}};
  members.update(place);
  journal_.write("picture", members);
}

void DrawnJournal::record_dialog(const std::string& focused_dialog) {
  if (std::exchange(dialog_, focused_dialog) != focused_dialog)
    journal_.write("dialog", {{"asks", focused_dialog}});
}

}  // namespace emberline
