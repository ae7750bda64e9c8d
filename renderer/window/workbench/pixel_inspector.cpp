#include "renderer/window/workbench/pixel_inspector.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

namespace emberline {
namespace {

// The parts of an inspection that are shown, apart from the picture's own values.
auto seen(const std::optional<PixelInspection>& p) {
  return p ? std::tuple(p->known, p->x, p->y, p->samples, p->explanation)
           : std::tuple(false, -1, -1, 0u, std::string());
}

}  // namespace

PixelInspector::PixelInspector(RenderSession& session, Navigator& navigator,
                               MaterialSelection& selection, WindowState& window,
                               MessageLog& messages, Journal& journal,
                               std::function<void(const std::string&)> copy_text)
    : session_(session),
      navigator_(navigator),
      selection_(selection),
      window_(window),
      messages_(messages),
      journal_(journal),
      copy_text_(std::move(copy_text)) {}

void PixelInspector::scene_arrived() {
  selection_.material = -1;
  clicked_.reset();
  picked_.reset();
}

bool PixelInspector::update() {
  const bool inspected = refresh_inspection(), explained = refresh_explanation();
  return inspected || explained;
}

void PixelInspector::point_at(const std::optional<Vec2i>& pixel) {
  pointed_ = pixel;
  refresh_inspection();
}

void PixelInspector::toggle() {
  window_.inspector = !window_.inspector;
  refresh_inspection();
}

void PixelInspector::select_at(const Vec2i& pixel) {
  clicked_ = picked_ = pixel;
  refresh_explanation();
  point_at(pixel);
}

void PixelInspector::orbit_around(const Vec2i& pixel) {
  pivot_ = pixel;
  refresh_inspection();
}

// True if there is something new to be seen.
bool PixelInspector::refresh_inspection() {
  const std::optional<PixelInspection> before = std::exchange(inspection_, std::nullopt);
  if (pointed_ && (window_.inspector || clicked_ || pivot_)) {
    inspection_ = session_.inspect(pointed_->x, pointed_->y);
    if (inspection_ && inspection_->known) serve_clicks();
  } else if (before) {
    session_.end_inspection();
  }
  return seen(inspection_) != seen(before);
}

void PixelInspector::serve_clicks() {
  const Vec2i at(inspection_->x, inspection_->y);
  if (clicked_ == at) {
    clicked_.reset();
    selection_.material = inspection_->material;
    selection_.show_tab = selection_.material >= 0;
    journal_.write(
        "select",
        {{"x", at.x}, {"y", at.y}, {"material", selection_.material}, {"id", inspection_->id}});
  }
  if (pivot_ == at) {
    pivot_.reset();
    if (inspection_->id != 0) navigator_.look_at(inspection_->position);
  }
}

void PixelInspector::toggle_explanation() {
  explains_ = !explains_;
  if (explains_ && pointed_) picked_ = pointed_;
  refresh_explanation();
}

// True if there is something new to be seen.
bool PixelInspector::refresh_explanation() {
  session_.pick(explains_ ? picked_ : std::nullopt);
  const std::optional<PixelInspection> before = std::exchange(explanation_, session_.picked());
  const bool news = seen(explanation_) != seen(before);
  if (news && explanation_ && explanation_->known) {
    journal_.write("explanation", {{"x", explanation_->x},
                                   {"y", explanation_->y},
                                   {"samples", explanation_->samples},
                                   {"text", explanation_text()}});
  }
  return news;
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
  journal_.write("copied", {{"text", text}});
  messages_.note("copied: why the pixel is done");
}

void PixelInspector::copy_values() {
  if (!inspection_) return;
  const PixelInspection& p = *inspection_;
  const std::string text =
      fmt::format("pixel {},{}: {} {} {} alpha {} samples {}", p.x, p.y, p.radiance.x, p.radiance.y,
                  p.radiance.z, p.alpha, p.samples);
  copy_text_(text);
  journal_.write("pixel", {{"x", p.x},
                           {"y", p.y},
                           {"rgb", {p.radiance.x, p.radiance.y, p.radiance.z}},
                           {"alpha", p.alpha},
                           {"samples", p.samples},
                           {"known", p.known},
                           {"id", p.id},
                           {"material", p.material}});
  messages_.note("copied: " + text);
}

}  // namespace emberline
