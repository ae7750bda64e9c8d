#include "renderer/session/overlay_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "io/image/output.h"
#include "renderer/core/readable.h"
#include "renderer/engine/live_picture.h"
#include "renderer/output/refinement_output.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {
namespace {

constexpr std::array kOverlays = {
    OverlayEntry{"none", "", ""},
    OverlayEntry{"samples", "samples per pixel", "samples"},
    OverlayEntry{"error", "estimated error of each pixel as displayed", "error"},
    OverlayEntry{"stop", "why each pixel got no more samples", "stop"},
    OverlayEntry{"time", "time spent on each pixel", "time"},
    OverlayEntry{"not finite", "samples that were NaN or infinite; they count as black",
                 "non_finite"},
    OverlayEntry{"tree", "how the adaptive driver divided the frame for its first samples", ""}};

std::string legend(const HeatmapQuantity& quantity, const ValueRange& range) {
  const DisplayUnit unit = display_unit(std::string(quantity.unit), range.max);
  return fmt::format("{} to {}{}{} {}", number_text(range.min * unit.factor),
                     number_text(range.max * unit.factor), unit.name.empty() ? "" : " ", unit.name,
                     quantity.title);
}

}  // namespace

std::span<const OverlayEntry> overlay_table() { return kOverlays; }

const HeatmapQuantity* overlay_quantity(ViewOverlay overlay) {
  const std::string_view name = kOverlays[size_t(overlay)].quantity;
  return name.empty() ? nullptr : &find_heatmap_quantity(name);
}

std::optional<Aov> overlay_aov(ViewOverlay overlay) {
  const HeatmapQuantity* quantity = overlay_quantity(overlay);
  return quantity ? quantity->aov : std::nullopt;
}

std::string draw_overlay(const HeatmapQuantity& quantity, std::span<const std::string> names,
                         std::span<const float> channels, const Rect& crop,
                         const HeatmapStyle& style, std::span<uint8_t> rgba8) {
  QuantityPlane plane(quantity, names, crop);
  plane.write_tile(crop, channels);
  HeatmapStyle drawn = style;
  drawn.plain = true;
  std::string legend_text(quantity.title);
  if (!quantity.categories) {
    if (!drawn.range) {
      drawn.range = automatic_range(plane.plane(), drawn.logarithmic, quantity.bright);
    }
    legend_text = legend(quantity, *drawn.range);
  }
  const BytePicture picture = draw_quantity(quantity, plane.plane(), drawn);
  for (size_t i = 0; i < size_t(crop.area()); ++i) {
    std::copy_n(&picture.values[3 * i], 3, &rgba8[4 * i]);
    rgba8[4 * i + 3] = 255;
  }
  return legend_text;
}

std::string draw_stops(std::span<const float> stops, const Rect& crop, std::span<uint8_t> rgba8) {
  const std::vector<std::string> name = {"stop"};
  std::string legend_text =
      draw_overlay(*overlay_quantity(ViewOverlay::kStop), name, stops, crop, {}, rgba8);
  const auto unfinished_count = std::ranges::count(stops, float(PixelStop::kUnfinished));
  if (unfinished_count == 0) return legend_text;
  return legend_text + "; " + readable_percent(double(unfinished_count) / double(stops.size())) +
         " unfinished";
}

void draw_tree(const RefinementTree& tree, const Grading& grading, std::span<const float> rgba,
               int width, std::span<uint8_t> rgba8) {
  // Draws after the display transform, so that borders are equally visible on light and dark areas.
  std::vector<float> shown(rgba.begin(), rgba.end());
  grading.to_display(shown);
  draw_leaf_borders(tree, shown, width);
  for (size_t i = 0; i < shown.size(); ++i) rgba8[i] = i % 4 == 3 ? 255 : to_byte(shown[i]);
}

}  // namespace emberline
