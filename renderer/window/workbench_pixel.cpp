// The pixel under the cursor, and the one whose end is to be explained.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "renderer/window/workbench.h"

namespace emberline {

void Workbench::point_at(const std::optional<Vec2i>& pixel) {
  pointed_ = pixel;
  refresh_inspection();
}

void Workbench::select_at(const Vec2i& pixel) {
  clicked_ = picked_ = pixel;
  refresh_explanation();
  point_at(pixel);
}

void Workbench::refresh_inspection() {
  if (!pointed_ || (!show_inspector && !clicked_ && !pivot_pixel_)) {
    if (inspection_) session_.end_inspection();
    inspection_.reset();
    return;
  }
  inspection_ = session_.inspect(pointed_->x, pointed_->y);
  if (!inspection_ || !inspection_->known) return;
  const auto is_at = [&](const std::optional<Vec2i>& pixel) {
    return pixel && pixel->x == inspection_->x && pixel->y == inspection_->y;
  };
  if (is_at(clicked_)) {
    material_ = inspection_->material;
    show_material = material_ >= 0;
    clicked_.reset();
    journal.write("select", {{"x", inspection_->x},
                             {"y", inspection_->y},
                             {"material", material_},
                             {"id", inspection_->id}});
  }
  if (is_at(pivot_pixel_)) {
    if (inspection_->id != 0) {
      look_at(inspection_->position);
    }
    pivot_pixel_.reset();
  }
}

// The panel comes with the pixel under the cursor; without one, with that of before.
void Workbench::explain() {
  show_explanation = !show_explanation;
  if (show_explanation && pointed_) picked_ = pointed_;
  refresh_explanation();
}

// True if there is something new to be seen.
bool Workbench::refresh_explanation() {
  session_.pick(show_explanation ? picked_ : std::nullopt);
  std::optional<PixelInspection> now = session_.picked();
  const auto seen = [](const std::optional<PixelInspection>& p) {
    return p ? std::tuple(p->known, p->x, p->y, p->samples, p->explanation)
             : std::tuple(false, -1, -1, 0u, std::string());
  };
  const bool news = seen(now) != seen(explanation_);
  explanation_ = std::move(now);
  if (news && explanation_ && explanation_->known) {
    journal.write("explanation", {{"x", explanation_->x},
                                  {"y", explanation_->y},
                                  {"samples", explanation_->samples},
                                  {"text", explanation_text()}});
  }
  return news;
}

std::string Workbench::explanation_text() const {
  if (!explanation_ || !explanation_->known) return {};
  const PixelInspection& p = *explanation_;
  if (!p.explanation.empty()) return p.explanation;
  return fmt::format("pixel {},{}: {} samples\nmean {:.6g} {:.6g} {:.6g}\n", p.x, p.y, p.samples,
                     p.radiance.x, p.radiance.y, p.radiance.z);
}

void Workbench::copy_explanation() {
  const std::string text = explanation_text();
  if (text.empty()) return;
  if (copy_text) copy_text(text);
  journal.write("copied", {{"text", text}});
  say(Message::Level::kNote, "copied: why the pixel is done");
}

void Workbench::copy_pixel() {
  if (!inspection_) return;
  const PixelInspection& p = *inspection_;
  const std::string text =
      fmt::format("pixel {},{}: {} {} {} alpha {} samples {}", p.x, p.y, p.radiance.x, p.radiance.y,
                  p.radiance.z, p.alpha, p.samples);
  if (copy_text) copy_text(text);
  journal.write("pixel", {{"x", p.x},
                          {"y", p.y},
                          {"rgb", {p.radiance.x, p.radiance.y, p.radiance.z}},
                          {"alpha", p.alpha},
                          {"samples", p.samples},
                          {"known", p.known},
                          {"id", p.id},
                          {"material", p.material}});
  say(Message::Level::kNote, "copied: " + text);
}

}  // namespace emberline
