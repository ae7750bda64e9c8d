// Overlays for a session's picture: heatmaps, and the leaves of an adaptive driver's refinement
// tree.
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
  std::string_view quantity;  // name in heatmap_quantity_table(); empty if the overlay is not a
                              // heatmap
};
// Indexed by ViewOverlay.
std::span<const OverlayEntry> overlay_table();

// Returns the quantity that an overlay shows; null if the overlay is not a heatmap.
const HeatmapQuantity* overlay_quantity(ViewOverlay overlay);
// Returns the channel that an overlay needs in addition to R G B A and `samples`, if any.
std::optional<Aov> overlay_aov(ViewOverlay overlay);

// Draws a quantity as opaque 8-bit RGBA, without a legend. `channels` are a film's interleaved
// channels, and `names` come from film_channels(). Returns the legend's text: the range of the
// colours.
std::string draw_overlay(const HeatmapQuantity& quantity, std::span<const std::string> names,
                         std::span<const float> channels, const Rect& crop,
                         const HeatmapStyle& style, std::span<uint8_t> rgba8);

// Draws the PixelStop values of the crop's pixels. Returns the legend's text, which includes the
// fraction of pixels that are not finished.
std::string draw_stops(std::span<const float> stops, const Rect& crop, std::span<uint8_t> rgba8);

// Draws the picture in display values, and the borders of the tree's leaves over it.
void draw_tree(const RefinementTree& tree, const Grading& grading, std::span<const float> rgba,
               int width, std::span<uint8_t> rgba8);

}  // namespace emberline
