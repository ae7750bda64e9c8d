#include "renderer/window/workbench/pixel_inspector.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "renderer/window/workbench/workbench.h"

namespace emberline {
namespace {

// Returns the displayed members of an inspection, except the values that come from the picture
// itself.
auto displayed_values(const std::optional<PixelInspection>& p) {
  return p ? std::tuple(p->known, p->x, p->y, p->samples, p->explanation)
           : std::tuple(false, -1, -1, 0u, std::string());
}

}  // namespace

void PixelInspector::on_new_scene() {
  bench_.selection.material = -1;
  clicked_.reset();
  picked_.reset();
}

bool PixelInspector::update() {
  const bool inspected = refresh_inspection(), explained = refresh_explanation();
  return inspected || explained;
}

void PixelInspector::set_cursor_pixel(const std::optional<Vec2i>& pixel) {
  cursor_pixel_ = pixel;
  refresh_inspection();
}

void PixelInspector::toggle() {
  bench_.window.inspector = !bench_.window.inspector;
  refresh_inspection();
}

void PixelInspector::select_at(const Vec2i& pixel) {
  clicked_ = picked_ = pixel;
  refresh_explanation();
  set_cursor_pixel(pixel);
}

void PixelInspector::orbit_around(const Vec2i& pixel) {
  pivot_ = pixel;
  refresh_inspection();
}

// Returns whether there is something new to display.
bool PixelInspector::refresh_inspection() {
  const std::optional<PixelInspection> before = std::exchange(inspection_, std::nullopt);
  if (cursor_pixel_ && (bench_.window.inspector || clicked_ || pivot_)) {
    inspection_ = bench_.session.inspect(cursor_pixel_->x, cursor_pixel_->y);
    if (inspection_ && inspection_->known) handle_clicks();
  } else if (before) {
    bench_.session.end_inspection();
  }
  return displayed_values(inspection_) != displayed_values(before);
}

void PixelInspector::handle_clicks() {
  const Vec2i at(inspection_->x, inspection_->y);
  if (clicked_ == at) {
    clicked_.reset();
    bench_.selection.material = inspection_->material;
    bench_.selection.show_tab = bench_.selection.material >= 0;
    bench_.journal.write("select", {{"x", at.x},
                                    {"y", at.y},
                                    {"material", bench_.selection.material},
                                    {"id", inspection_->id}});
  }
  if (pivot_ == at) {
    pivot_.reset();
    if (inspection_->id != 0) bench_.navigator.look_at(inspection_->position);
  }
}

void PixelInspector::toggle_explanation() {
  shows_explanation_ = !shows_explanation_;
  if (shows_explanation_ && cursor_pixel_) picked_ = cursor_pixel_;
  refresh_explanation();
}

// Returns whether there is something new to display.
bool PixelInspector::refresh_explanation() {
  bench_.session.pick(shows_explanation_ ? picked_ : std::nullopt);
  const std::optional<PixelInspection> before =
      std::exchange(explanation_, bench_.session.picked());
  const bool changed = displayed_values(explanation_) != displayed_values(before);
  if (changed && explanation_ && explanation_->known) {
    bench_.journal.write("explanation", {{"x", explanation_->x},
                                         {"y", explanation_->y},
                                         {"samples", explanation_->samples},
                                         {"text", explanation_text()}});
  }
  return changed;
}

std::string PixelInspector::explanation_text() const {
  if (!explanation_ || !explanation_->known) return {};
  const PixelInspection& p = *explanation_;
  if (!p.explanation.empty()) return p.explanation;
  return fmt::format("pixel {},{}: {} samples\nmean {:.6g} {:.6g} {:.6g}\n", p.x, p.y, p.samples,
                     p.radiance.x, p.radiance.y, p.radiance.z);
}

void PixelInspector::copy_explanation() {
  const std::string text = explanation_text();
  if (text.empty()) return;
  copy_text_(text);
  bench_.journal.write("copied", {{"text", text}});
  bench_.messages.note("Copied the explanation of the pixel");
}

void PixelInspector::copy_values() {
  if (!inspection_) return;
  const PixelInspection& p = *inspection_;
  const std::string text =
      fmt::format("pixel {},{}: {} {} {} alpha {} samples {}", p.x, p.y, p.radiance.x, p.radiance.y,
                  p.radiance.z, p.alpha, p.samples);
  copy_text_(text);
  bench_.journal.write("pixel", {{"x", p.x},
                                 {"y", p.y},
                                 {"rgb", {p.radiance.x, p.radiance.y, p.radiance.z}},
                                 {"alpha", p.alpha},
                                 {"samples", p.samples},
                                 {"known", p.known},
                                 {"id", p.id},
                                 {"material", p.material}});
  bench_.messages.note("Copied: " + text);
}

}  // namespace emberline
