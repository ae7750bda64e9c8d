#include "renderer/window/picture/view.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "renderer/core/readable.h"
#include "renderer/statistics/heatmap_quantity.h"
#include "renderer/window/panels/edit_entries.h"
#include "renderer/window/panels/theme.h"

namespace emberline {
namespace {

constexpr double kPixelZoom = 2.0;    // from this zoom on, pixels are drawn as squares
constexpr double kValuesZoom = 28.0;  // from this zoom on, pixels contain their values
constexpr float kMinMark = 9.0f;      // smallest size of the frame around the picked pixel
constexpr ImU32 kBackground = IM_COL32(24, 24, 25, 255);
constexpr ImU32 kShadow = IM_COL32(0, 0, 0, 160);

ImU32 colour(const ImVec4& value, float alpha = 1.0f) {
  return ImGui::GetColorU32(ImVec4(value.x, value.y, value.z, alpha));
}

ImVec2 corner(const Workbench& bench, float x, float y) {
  const Vec2f at = bench.placement.to_screen(Vec2f(x, y));
  return {at.x, at.y};
}

// Draws a rectangle with a dark border, so that it is visible on any picture.
void outline(ImDrawList& list, const ImVec2& a, const ImVec2& b, ImU32 ink) {
  list.AddRect({a.x - 1, a.y - 1}, {b.x + 1, b.y + 1}, kShadow);
  list.AddRect(a, b, ink);
}

void draw_rect(const Workbench& bench, ImDrawList& list, const Rect& rect, ImU32 ink) {
  outline(list, corner(bench, float(rect.x0), float(rect.y0)),
          corner(bench, float(rect.x1), float(rect.y1)), ink);
}

// Draws a frame around a pixel, with a margin if the pixel is small.
void draw_picked(const Workbench& bench, ImDrawList& list, const Vec2i& pixel) {
  const ImVec2 a = corner(bench, float(pixel.x), float(pixel.y));
  const ImVec2 b = corner(bench, float(pixel.x + 1), float(pixel.y + 1));
  const float margin = std::max(0.0f, 0.5f * (kMinMark - (b.x - a.x)));
  outline(list, {a.x - margin, a.y - margin}, {b.x + margin, b.y + margin}, IM_COL32_WHITE);
}

// Marks a bucket in progress by four corners, as renderers traditionally do.
void draw_bucket(const Workbench& bench, ImDrawList& list, const Rect& rect) {
  const ImVec2 a = corner(bench, float(rect.x0), float(rect.y0));
  const ImVec2 b = corner(bench, float(rect.x1), float(rect.y1));
  const float arm = 0.3f * std::min(b.x - a.x, b.y - a.y);
  const ImU32 ink = colour(accent_colour());
  for (const auto& [x, dx] : {std::pair{a.x, arm}, std::pair{b.x, -arm}}) {
    for (const auto& [y, dy] : {std::pair{a.y, arm}, std::pair{b.y, -arm}}) {
      list.AddLine({x, y}, {x + dx, y}, ink, 2.0f);
      list.AddLine({x, y}, {x, y + dy}, ink, 2.0f);
    }
  }
}

// Writes the linear values of each visible pixel into that pixel.
void draw_values(const Workbench& bench, ImDrawList& list, const SessionPicture& picture) {
  const Rect& area = bench.placement.area();
  const Vec2f first = bench.placement.to_picture(Vec2f(float(area.x0), float(area.y0)));
  const Vec2f last = bench.placement.to_picture(Vec2f(float(area.x1), float(area.y1)));
  const Rect visible = Rect{int(std::floor(first.x)), int(std::floor(first.y)),
                            int(std::ceil(last.x)), int(std::ceil(last.y))}
                           .intersect({0, 0, picture.width, picture.height});
  const float size = 0.26f * float(bench.placement.zoom());
  for (int y = visible.y0; y < visible.y1; ++y) {
    for (int x = visible.x0; x < visible.x1; ++x) {
      const size_t i = 4 * (size_t(y) * size_t(picture.width) + size_t(x));
      const uint8_t* const shown = &picture.rgba8[i];
      const bool light = 2 * shown[0] + 5 * shown[1] + shown[2] > 8 * 110;
      const ImVec2 at = corner(bench, float(x), float(y));
      for (int c = 0; c < 3; ++c) {
        const std::string text = fmt::format("{:.3g}", picture.rgba[i + size_t(c)]);
        list.AddText(ImGui::GetFont(), size,
                     {at.x + 0.12f * size, at.y + float(c) * 1.15f * size + 0.2f * size},
                     light ? IM_COL32(0, 0, 0, 255) : IM_COL32(255, 255, 255, 255), text.c_str());
      }
    }
  }
}

void draw_label(ImDrawList& list, const ImVec2& at, const std::string& text) {
  const float pad = 0.3f * ImGui::GetFontSize();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  list.AddRectFilled({at.x - pad, at.y - pad}, {at.x + size.x + pad, at.y + size.y + pad},
                     IM_COL32(20, 20, 20, 200), pad);
  list.AddText(at, ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
}

// Draws the legend of an overlay over the upper edge of the picture.
void draw_legend(const Workbench& bench, ImDrawList& list, const SessionPicture& picture) {
  const ViewOverlay overlay = bench.session.settings().overlay;
  if (overlay == ViewOverlay::kNone || picture.overlay_legend.empty()) return;
  const float em = ImGui::GetFontSize();
  const Rect& area = bench.placement.area();
  ImVec2 at(float(area.x0) + em, float(area.y0) + em);
  draw_label(list, at, picture.overlay_legend);
  at.y += 1.8f * em;
  if (overlay == ViewOverlay::kStop) {
    for (const Category& category : stop_categories()) {
      draw_label(list, {at.x + 1.6f * em, at.y}, category.name);
      const Rgb8& c = category.colour;
      list.AddRectFilled({at.x - 3, at.y - 3}, {at.x + em + 3, at.y + em + 3},
                         IM_COL32(20, 20, 20, 200));  // background for the swatch
      list.AddRectFilled(at, {at.x + em, at.y + em}, IM_COL32(c[0], c[1], c[2], 255));
      at.y += 1.7f * em;
    }
  } else if (overlay != ViewOverlay::kTree) {
    constexpr int kSteps = 64;
    const float width = 14.0f * em;
    for (int i = 0; i < kSteps; ++i) {
      const Rgb8 c =
          colour_of(bench.session.settings().render.heatmap_style.colours, (i + 0.5) / kSteps);
      list.AddRectFilled({at.x + width * float(i) / kSteps, at.y},
                         {at.x + width * float(i + 1) / kSteps, at.y + 0.7f * em},
                         IM_COL32(c[0], c[1], c[2], 255));
    }
    list.AddRect({at.x - 1, at.y - 1}, {at.x + width + 1, at.y + 0.7f * em + 1}, kShadow);
  }
}

// Draws the wipe's line and labels both sides.
void draw_wipe(const Workbench& bench, ImDrawList& list, int width, int height) {
  const float x = bench.comparison.wipe_position() * float(width);
  const ImVec2 a = corner(bench, x, 0.0f), b = corner(bench, float(width), float(height));
  list.AddLine({a.x, a.y}, {a.x, b.y}, kShadow, 3.0f);
  list.AddLine({a.x, a.y}, {a.x, b.y}, colour(accent_colour()), 1.0f);
  const float gap = ImGui::GetFontSize();
  const float top = std::max(a.y, float(bench.placement.area().y0)) + gap;
  const bool stored = bench.comparison.wipe() == Wipe::kStored;
  const std::string left = stored ? "A: current" : "Denoised";
  draw_label(list, {a.x - 1.3f * gap - ImGui::CalcTextSize(left.c_str()).x, top}, left);
  draw_label(list, {a.x + 1.3f * gap, top},
             !stored                          ? "Raw"
             : bench.comparison.graded_as_a() ? "B: kept"
                                              : "B: kept, own display settings");
}

// Fills the area around the picture, whose corners are `a` and `b`. Leaves out the pixels under the
// picture, because software OpenGL would draw them twice.
void draw_background(ImDrawList& list, const Rect& area, const ImVec2& a, const ImVec2& b) {
  const ImVec2 first(float(area.x0), float(area.y0)), last(float(area.x1), float(area.y1));
  const float top = std::clamp(a.y, first.y, last.y), bottom = std::clamp(b.y, first.y, last.y);
  const auto fill = [&](float x0, float y0, float x1, float y1) {
    if (x0 < x1 && y0 < y1) list.AddRectFilled({x0, y0}, {x1, y1}, kBackground);
  };
  fill(first.x, first.y, last.x, top);
  fill(first.x, bottom, last.x, last.y);
  fill(first.x, top, std::clamp(a.x, first.x, last.x), bottom);
  fill(std::clamp(b.x, first.x, last.x), top, last.x, bottom);
}

void row(const char* name, const std::string& value) {
  ImGui::TextColored(muted_colour(), "%s", name);
  ImGui::SameLine(6.5f * ImGui::GetFontSize());
  ImGui::TextUnformatted(value.c_str());
}

// Returns whether the right side of the wipe has a picture.
bool has_other_side(const Workbench& bench) {
  const Wipe wipe = bench.comparison.wipe();
  if (wipe == Wipe::kStored) return bench.comparison.picture_b() != nullptr;
  return wipe == Wipe::kRaw && bench.picture() && !bench.picture()->raw8.empty();
}

}  // namespace

void PictureView::upload(const Workbench& bench) {
  const std::shared_ptr<const SessionPicture>& picture = bench.picture();
  if (picture && picture != drawn_) {
    picture_.upload(picture->width, picture->height, picture->rgba8);
    drawn_ = picture;
  }
  const bool raw = bench.comparison.wipe() == Wipe::kRaw;
  const std::shared_ptr<const SessionPicture>& b = raw ? picture : bench.comparison.picture_b();
  if (has_other_side(bench) && (b != drawn_b_ || raw != drawn_b_raw_)) {
    picture_b_.upload(b->width, b->height, raw ? b->raw8 : b->rgba8);
    drawn_b_ = b;
    drawn_b_raw_ = raw;
  }
}

void PictureView::draw(Workbench& bench, const std::optional<Rect>& dragged_region) {
  upload(bench);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const Rect& area = bench.placement.area();
  if (!drawn_ || picture_.empty()) {
    list.AddRectFilled({float(area.x0), float(area.y0)}, {float(area.x1), float(area.y1)},
                       kBackground);
    return;
  }
  const int width = drawn_->width, height = drawn_->height;
  // At 1:1, interpolation changes nothing, but software OpenGL would still spend time on it.
  const double zoom = bench.placement.zoom();
  const bool pixels = zoom >= kPixelZoom || zoom == 1.0;
  picture_.set_pixelated(pixels);
  picture_b_.set_pixelated(pixels);

  const ImVec2 a = corner(bench, 0, 0), b = corner(bench, float(width), float(height));
  draw_background(list, area, a, b);
  list.PushClipRect({float(area.x0), float(area.y0)}, {float(area.x1), float(area.y1)});
  // A and B are drawn side by side, without overlap: llvmpipe, Mesa's software OpenGL, omits the
  // upper of two overlapping pictures where nothing else is drawn.
  const bool wipe = has_other_side(bench) && !picture_b_.empty();
  const float wipe_position = wipe ? bench.comparison.wipe_position() : 1.0f;
  const float line = wipe ? corner(bench, wipe_position * float(width), 0.0f).x : b.x;
  plain_.begin(list);
  list.AddImage(picture_.id(), a, {line, b.y}, {0.0f, 0.0f}, {wipe_position, 1.0f});
  if (wipe) list.AddImage(picture_b_.id(), {line, a.y}, b, {wipe_position, 0.0f}, {1.0f, 1.0f});
  PlainShader::end(list);
  if (wipe) draw_wipe(bench, list, width, height);
  for (const Rect& bucket : drawn_->in_progress) draw_bucket(bench, list, bucket);
  if (bench.placement.zoom() >= kValuesZoom) draw_values(bench, list, *drawn_);
  draw_legend(bench, list, *drawn_);
  const ImU32 ink = IM_COL32(255, 255, 255, 220);
  if (bench.session.settings().region)
    draw_rect(bench, list, *bench.session.settings().region, ink);
  if (dragged_region) draw_rect(bench, list, *dragged_region, colour(accent_colour()));
  if (const auto& pixel = bench.pixels.picked(); pixel && bench.pixels.shows_explanation()) {
    draw_picked(bench, list, *pixel);
  }
  if (const auto& pixel = bench.pixels.cursor_pixel(); pixel && pixels) {
    draw_rect(bench, list, {pixel->x, pixel->y, pixel->x + 1, pixel->y + 1}, ink);
  }
  list.PopClipRect();
}

void draw_inspector(const Workbench& bench) {
  if (!bench.window.inspector || !bench.pixels.inspection()) return;
  const PixelInspection& pixel = *bench.pixels.inspection();
  const Vec2f at = bench.placement.to_screen(Vec2f(float(pixel.x + 1), float(pixel.y + 1)));
  const float gap = ImGui::GetFontSize();
  const Rect& area = bench.placement.area();
  // Place the box on the side of the pixel that has enough room.
  const bool left = at.x + 18.0f * gap > float(area.x1),
             above = at.y + 13.0f * gap > float(area.y1);
  ImGui::SetNextWindowPos({at.x + (left ? -gap : gap), at.y + (above ? -gap : gap)},
                          ImGuiCond_Always, {left ? 1.0f : 0.0f, above ? 1.0f : 0.0f});
  ImGui::SetNextWindowBgAlpha(0.88f);
  ImGui::BeginTooltip();  // in front of every panel
  row("Pixel", fmt::format("{}, {}", pixel.x, pixel.y));
  row("RGB",
      fmt::format("{:.4g}  {:.4g}  {:.4g}", pixel.radiance.x, pixel.radiance.y, pixel.radiance.z));
  if (pixel.denoised) {
    const Rgb& d = *pixel.denoised;
    row("Denoised", fmt::format("{:.4g}  {:.4g}  {:.4g}", d.x, d.y, d.z));
  }
  if (pixel.alpha != 1.0f) row("Alpha", readable_number(pixel.alpha));
  row("Samples", pixel.known ? readable_count(pixel.samples) : "…");
  if (pixel.known && pixel.variance) {
    const Rgb& v = *pixel.variance;
    row("Std. error",
        fmt::format("{:.2g}  {:.2g}  {:.2g}", std::sqrt(v.x), std::sqrt(v.y), std::sqrt(v.z)));
  }
  if (pixel.known && pixel.non_finite > 0) row("Not finite", readable_count(pixel.non_finite));
  if (pixel.known && pixel.stop != PixelStop::kNone) {
    const bool is_unfinished = pixel.stop == PixelStop::kUnfinished;
    row("Stopped by", is_unfinished ? "not stopped yet" : pixel_stop_name(pixel.stop));
  }
  if (pixel.known) {
    row("Object",
        pixel.id == 0 ? "background" : fmt::format("{}  (id {})", pixel.object, pixel.id));
  }
  if (const auto scene = bench.session.scene(); pixel.known && pixel.material >= 0 && scene) {
    const auto& materials = scene->outline.materials;
    if (size_t(pixel.material) < materials.size()) {
      row("Material",
          display_name(materials[size_t(pixel.material)].name, "Material", pixel.material));
    }
  }
  ImGui::EndTooltip();
}

}  // namespace emberline
