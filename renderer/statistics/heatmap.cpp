#include "renderer/statistics/heatmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/statistics/pixel_text.h"
#include "renderer/statistics/row_sums.h"

namespace emberline {
namespace {

// ---- the legend below a heatmap

// Text, after a colour swatch if it is about a colour. Items are placed side by side and wrap to a
// new line.
struct LegendItem {
  std::string text;
  std::optional<Rgb8> swatch = std::nullopt;
};

// A colour bar with its scale below and a histogram of the plane's values above.
struct LegendBar {
  const Plane& plane;
  ValueScale scale;
  ColourMap colours;
  double factor = 1;  // labels show value x factor
};

constexpr Rgb8 kBackground = {30, 30, 30}, kEdge = {140, 140, 140}, kTitle = {255, 255, 255},
               kText = {205, 205, 205}, kHistogram = {150, 150, 150};

// In units of the legend's scale: one pixel of a letter.
constexpr int kPadding = 6, kLineGap = 5, kItemGap = 16, kSwatch = 9, kSwatchGap = 4;
constexpr int kHistogramHeight = 26, kBarHeight = 9, kTickHeight = 3;
constexpr int kBinWidth = 2, kWidestBin = 8;
constexpr int kLeastWidth = 220, kTickRoom = 48;

// Picture pixels per pixel of a letter: 2 at 1280x720, 6 at 3840x2160.
int letter_scale(int width, int height) {
  return std::max(1, int(std::lround(std::sqrt(double(width) * double(height)) / 480)));
}

int item_width(const LegendItem& item, int scale) {
  return text_width(item.text, scale) + (item.swatch ? (kSwatch + kSwatchGap) * scale : 0);
}

// The upper left corner of each item, and the height of all lines.
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

// Equally wide bins over the scale. For whole numbers each bin holds the same number of them, and
// the first number is in the middle of its bin.
struct Bins {
  std::vector<uint64_t> counts;
  double first = 0,
         bin = 0;  // start of the first bin and width of a bin, as fractions of the scale
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
    // A bin that is not empty shows at least one pixel.
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

// A picture with space for `width` x `height` pixels in its upper left corner. Below are the items,
// of which the first is the title, and the bar if there is one. Letters grow with the frame in
// about the same proportion; a small frame's legend is wider than the frame.
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

// ---- legend texts

constexpr Rgb8 kNoCategory = {128, 128, 128};

std::string pixels_text(uint64_t count) {
  return fmt::format("{} {}", count, count == 1 ? "pixel" : "pixels");
}

// "12.3 %"; never "0 %" for a nonzero part, or "100 %" for less than all.
std::string share_text(uint64_t part, uint64_t whole) {
  const double percent = 100 * double(part) / double(whole);
  if (part > 0 && percent < 0.05) return "< 0.1 %";
  if (part < whole && percent > 99.95) return "> 99.9 %";
  return fmt::format("{:.{}f} %", percent, part == whole || part == 0 ? 0 : 1);
}

// fn(value) is the colour of a pixel.
template <typename Function>
void paint(BytePicture& picture, const Plane& plane, const Function& fn) {
  for_each_row(plane.height, [&](int y) {
    for (int x = 0; x < plane.width; ++x) {
      const Rgb8 colour = fn(plane.at(x, y));
      std::copy_n(colour.data(), 3, picture.at(x, y));
    }
  });
}

std::string title_text(const HeatmapSettings& settings, const ToldUnit& unit) {
  std::string title = settings.title;
  if (!unit.name.empty()) title += " (" + unit.name + ")";
  if (settings.logarithmic) title += ", logarithmic";
  return title;
}

// Reports values outside the scale, since their colours do not show it.
void add_outside(const Plane& plane, const ValueScale& scale, uint64_t values,
                 std::vector<LegendItem>* items) {
  uint64_t below = 0, above = 0;
  for (const float value : plane.values) {
    const double place = scale.position(double(value));
    below += place < 0.0;
    above += place > 1.0;
  }
  if (below > 0) items->push_back({share_text(below, values) + " below the scale"});
  if (above > 0) items->push_back({share_text(above, values) + " above the scale"});
}

std::vector<LegendItem> describe(const Plane& plane, const HeatmapSettings& settings,
                                 const ValueScale& scale, const PlaneStatistics& s,
                                 const ToldUnit& unit) {
  const auto told = [&](double value) { return number_text(value * unit.factor); };
  std::vector<LegendItem> items = {{title_text(settings, unit)}};
  if (s.constant()) {
    items.push_back({(s.no_value == 0 ? "uniform: every pixel has " : "uniform: every value is ") +
                     told(s.minimum)});
  } else if (s.values > 0) {
    items.push_back({"minimum " + told(s.minimum)});
    items.push_back({"mean " + told(s.mean)});
    if (settings.rms) items.push_back({"RMS " + told(s.rms)});
    items.push_back({"maximum " + told(s.maximum)});
    // So few nonzero pixels are easily overlooked.
    if (s.not_zero * 100 <= s.values) items.push_back({"not 0 in " + pixels_text(s.not_zero)});
    add_outside(plane, scale, s.values, &items);
  }
  if (s.no_value > 0) {
    items.push_back({"no value: " + pixels_text(s.no_value), colour_of(settings.colours, NAN)});
  }
  return items;
}

}  // namespace

BytePicture draw_heatmap(const Plane& plane, const HeatmapSettings& settings) {
  assert(plane.width > 0 && plane.height > 0);
  const ValueScale scale(settings.range
                             ? *settings.range
                             : automatic_range(plane, settings.logarithmic, settings.bright),
                         settings.logarithmic);
  BytePicture picture;
  if (settings.plain) {
    picture = BytePicture(plane.width, plane.height, {0, 0, 0});
  } else {
    const PlaneStatistics s = plane_statistics(plane);
    const ToldUnit unit = told_unit(settings.unit, scale.range().most);
    const LegendBar bar{plane, scale, settings.colours, unit.factor};
    picture = frame_with_legend(plane.width, plane.height,
                                describe(plane, settings, scale, s, unit), &bar);
  }
  paint(picture, plane,
        [&](float value) { return colour_of(settings.colours, scale.position(double(value))); });
  return picture;
}

BytePicture draw_category_map(const Plane& plane, std::span<const Category> categories,
                              const HeatmapSettings& settings) {
  assert(plane.width > 0 && plane.height > 0);
  BytePicture picture(plane.width, plane.height, kNoCategory);
  if (!settings.plain) {
    std::vector<LegendItem> items = {{settings.title}};
    const uint64_t whole = plane.values.size();
    uint64_t left = whole;
    for (const Category& category : categories) {
      const auto count = uint64_t(std::ranges::count(plane.values, category.value));
      if (count == 0) continue;
      left -= count;
      items.push_back({category.name + ": " + share_text(count, whole), category.colour});
    }
    if (left > 0) items.push_back({"no value: " + share_text(left, whole), kNoCategory});
    picture = frame_with_legend(plane.width, plane.height, items, nullptr);
  }
  paint(picture, plane, [&](float value) {
    const auto found = std::ranges::find(categories, value, &Category::value);
    return found == categories.end() ? kNoCategory : found->colour;
  });
  return picture;
}

}  // namespace emberline
