// Overlays of a session's picture: heatmaps and the refinement tree.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/session/grading.h"
#include "renderer/session/view_settings.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

class RefinementTree;

struct OverlayEntry {
  std::string_view name, summary;
  std::string_view quantity;  // of heatmap_quantity_table(); empty: it is none
};
// By ViewOverlay.
std::span<const OverlayEntry> overlay_table();

// The quantity that an overlay shows; null for those that are none.
const HeatmapQuantity* overlay_quantity(ViewOverlay overlay);
// The channel beside R G B A and `samples` that an overlay needs.
std::optional<Aov> overlay_aov(ViewOverlay overlay);

// Draws a quantity of a film's channels (names as film_channels() gives them, values interleaved)
// as opaque 8-bit RGBA, without a legend. Returns the legend in words: what the colours run from
// and to.
std::string draw_overlay(const HeatmapQuantity& quantity, std::span<const std::string> names,
                         std::span<const float> channels, const Rect& crop,
                         const HeatmapStyle& style, std::span<uint8_t> rgba8);

// Draws the PixelStop values of the crop's pixels. The legend says which share of a frame still
// goes on.
std::string draw_stops(std::span<const float> stops, const Rect& crop, std::span<uint8_t> rgba8);

// The picture as displayed, with the borders of the tree's leaves over it.
void draw_tree(const RefinementTree& tree, const Grading& grading, std::span<const float> rgba,
               int width, std::span<uint8_t> rgba8);

}  // namespace emberline
