#include "renderer/statistics/heatmap_legend.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderer/core/vector.h"
#include "renderer/statistics/pixel_text.h"

namespace emberline {
namespace {

constexpr Rgb8 kBackground = {30, 30, 30}, kEdge = {140, 140, 140}, kTitle = {255, 255, 255},
               kText = {205, 205, 205}, kHistogram = {150, 150, 150};

// In units of the legend's scale: one pixel of a letter.
constexpr int kPadding = 6, kLineGap = 5, kItemGap = 16, kSwatch = 9, kSwatchGap = 4;
constexpr int kHistogramHeight = 26, kBarHeight = 9, kTickHeight = 3;
constexpr int kBinWidth = 2, kWidestBin = 8;
constexpr int kLeastWidth = 220, kTickRoom = 48;

// Two pixels to one of a letter at 1280x720, six at 3840x2160.
int letter_scale(int width, int height) {
  return std::max(1, int(std::lround(std::sqrt(double(width) * double(height)) / 480)));
}

int item_width(const LegendItem& item, int scale) {
  return text_width(item.text, scale) + (item.swatch ? (kSwatch + kSwatchGap) * scale : 0);
}

// Where each item's upper left corner is, and the height of all lines.
struct ItemLayout {
  std::vector<Vec2i> places;
  int height = 0;
};

ItemLayout lay_out(const std::vector<LegendItem>& items, int width, int scale) {
  ItemLayout layout;
  int x = 0, y = 0;
  for (const LegendItem& item : items) {
    const int needed = item_width(item, scale);
    if (x > 0 && x + needed > width) {
      x = 0;
      y += text_height(scale) + kLineGap * scale;
    }
    layout.places.emplace_back(x, y);
    x += needed + kItemGap * scale;
  }
  layout.height = y + text_height(scale);
  return layout;
}

void draw_item(BytePicture& picture, const LegendItem& item, int x, int y, int scale,
               const Rgb8& colour) {
  if (item.swatch) {
    const int size = kSwatch * scale;
    picture.fill({x, y, x + size, y + size}, kEdge);
    picture.fill({x + scale, y + scale, x + size - scale, y + size - scale}, *item.swatch);
    x += (kSwatch + kSwatchGap) * scale;
  }
  draw_text(picture, x, y, item.text, scale, colour);
}

bool whole_numbers(const Plane& plane) {
  return std::ranges::all_of(plane.values,
                             [](float v) { return !std::isfinite(v) || v == std::round(v); });
}

// Bins over the scale, equally wide. Of whole numbers each holds as many as the next and has its
// first in its middle.
struct Bins {
  std::vector<uint64_t> counts;
  double first = 0, bin = 0;  // where the first begins and a bin's width, in parts of the scale
};

Bins histogram_of(const LegendBar& bar, int bins) {
  const ValueRange& range = bar.scale.range();
  const double length = range.most - range.least;
  Bins h;
  h.bin = 1.0 / bins;
  if (!bar.scale.logarithmic() && whole_numbers(bar.plane)) {
    h.bin = std::ceil(length / bins) / length;
    h.first = -0.5 / length;
  }
  h.counts.assign(size_t(std::ceil((1.0 - h.first) / h.bin)), 0);
  for (const float value : bar.plane.values) {
    const double place = bar.scale.position(double(value));
    if (!(place >= 0.0 && place <= 1.0)) continue;
    h.counts[std::min(size_t((place - h.first) / h.bin), h.counts.size() - 1)]++;
  }
  return h;
}

void draw_histogram(BytePicture& picture, const LegendBar& bar, const Rect& area, int scale) {
  const Bins h = histogram_of(bar, std::max(1, area.width() / (kBinWidth * scale)));
  const uint64_t most = *std::ranges::max_element(h.counts);
  const double width = std::min(h.bin * area.width(), double(kWidestBin * scale));
  for (size_t i = 0; i < h.counts.size(); ++i) {
    if (h.counts[i] == 0) continue;
    const double middle = area.x0 + (h.first + (double(i) + 0.5) * h.bin) * area.width();
    const int x0 = std::clamp(int(std::lround(middle - 0.5 * width)), area.x0, area.x1 - 1);
    const int x1 = std::clamp(int(std::lround(middle + 0.5 * width)), x0 + 1, area.x1);
    // What is there is seen, be it one pixel.
    const double share = double(h.counts[i]) / double(most);
    const int height = std::max(scale, int(std::lround(share * area.height())));
    picture.fill({x0, area.y1 - height, x1, area.y1}, kHistogram);
  }
}

void draw_ticks(BytePicture& picture, const LegendBar& bar, const Rect& area, int scale) {
  int free_from = area.x0;
  for (const AxisTick& tick :
       bar.scale.ticks(std::max(2, area.width() / (kTickRoom * scale)), bar.factor)) {
    const double place = std::clamp(bar.scale.position(tick.value), 0.0, 1.0);
    const int x = area.x0 + int(std::lround(place * (area.width() - scale)));
    const int width = text_width(tick.label, scale);
    const int left =
        std::clamp(x - (width - scale) / 2, area.x0, std::max(area.x0, area.x1 - width));
    picture.fill({x, area.y0, x + scale, area.y0 + kTickHeight * scale}, kEdge);
    if (left < free_from) continue;
    draw_text(picture, left, area.y0 + (kTickHeight + 2) * scale, tick.label, scale, kText);
    free_from = left + width + kGlyphAdvance * scale;
  }
}

int bar_height(int scale) {
  return (kLineGap + kHistogramHeight + kBarHeight + kTickHeight + 2) * scale + text_height(scale);
}

void draw_bar(BytePicture& picture, const LegendBar& bar, int x0, int x1, int y, int scale) {
  y += kLineGap * scale;
  draw_histogram(picture, bar, {x0, y, x1, y + kHistogramHeight * scale}, scale);
  y += kHistogramHeight * scale;
  for (int x = x0; x < x1; ++x) {
    const Rgb8 colour = colour_of(bar.colours, (x - x0 + 0.5) / (x1 - x0));
    picture.fill({x, y, x + 1, y + kBarHeight * scale}, colour);
  }
  y += kBarHeight * scale;
  draw_ticks(picture, bar, {x0, y, x1, y}, scale);
}

}  // namespace

BytePicture frame_with_legend(int width, int height, const std::vector<LegendItem>& items,
                              const LegendBar* bar) {
  const int scale = letter_scale(width, height), padding = kPadding * scale;
  int inner = std::max(width - 2 * padding, (kLeastWidth - 2 * kPadding) * scale);
  for (const LegendItem& item : items) inner = std::max(inner, item_width(item, scale));
  const ItemLayout layout = lay_out(items, inner, scale);
  const int below = scale + 2 * padding + layout.height + (bar ? bar_height(scale) : 0);

  BytePicture picture(inner + 2 * padding, height + below, kBackground);
  picture.fill({0, height, picture.width, height + scale}, kEdge);
  if (width < picture.width) picture.fill({width, 0, width + scale, height}, kEdge);
  const int y = height + scale + padding;
  for (size_t i = 0; i < items.size(); ++i) {
    draw_item(picture, items[i], padding + layout.places[i].x, y + layout.places[i].y, scale,
              i == 0 ? kTitle : kText);
  }
  if (bar) draw_bar(picture, *bar, padding, padding + inner, y + layout.height, scale);
  return picture;
}

}  // namespace emberline
