#include "renderer/statistics/heatmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/parallel.h"
#include "renderer/core/readable.h"

namespace emberline {
namespace {

constexpr Rgb8 kNoCategory = {128, 128, 128};

std::string pixels_text(uint64_t count) {
  return readable_count(count) + (count == 1 ? " pixel" : " pixels");
}

// Formats a percentage such as "12.3 %". Never returns "0 %" for a nonzero part or "100 %" for less
// than the total.
std::string share_text(uint64_t part, uint64_t total) {
  const double percent = 100 * double(part) / double(total);
  if (part > 0 && percent < 0.05) return "< 0.1 %";
  if (part < total && percent > 99.95) return "> 99.9 %";
  return fmt::format("{:.{}f} %", percent, part == total || part == 0 ? 0 : 1);
}

// Gives each pixel the colour fn(value).
template <typename Function>
void paint(BytePicture& picture, const Plane& plane, const Function& fn) {
  for_each_row(plane.height, [&](int y) {
    for (int x = 0; x < plane.width; ++x) {
      const Rgb8 colour = fn(plane.at(x, y));
      std::copy_n(colour.data(), 3, picture.at(x, y));
    }
  });
}

std::string title_text(const HeatmapSettings& settings, const DisplayUnit& unit) {
  std::string title = settings.title;
  if (!unit.name.empty()) title += " (" + unit.name + ")";
  if (settings.logarithmic) title += ", log scale";
  return title;
}

// Adds the percentages of values below and above the scale to the items, because the clamped
// colours do not show them.
void add_out_of_range(const Plane& plane, const ValueScale& scale, uint64_t values,
                      std::vector<LegendItem>* items) {
  uint64_t below = 0, above = 0;
  for (const float value : plane.values) {
    const double position = scale.position(double(value));
    below += position < 0.0;
    above += position > 1.0;
  }
  if (below > 0) items->push_back({share_text(below, values) + " below the scale"});
  if (above > 0) items->push_back({share_text(above, values) + " above the scale"});
}

std::vector<LegendItem> describe(const Plane& plane, const HeatmapSettings& settings,
                                 const ValueScale& scale, const PlaneStatistics& s,
                                 const DisplayUnit& unit) {
  const auto format_value = [&](double value) { return number_text(value * unit.factor); };
  std::vector<LegendItem> items = {{title_text(settings, unit)}};
  if (s.constant()) {
    items.push_back({(s.no_value == 0 ? "uniform: every pixel has " : "uniform: every value is ") +
                     format_value(s.minimum)});
  } else if (s.values > 0) {
    items.push_back({"minimum " + format_value(s.minimum)});
    items.push_back({"mean " + format_value(s.mean)});
    if (settings.rms) items.push_back({"RMS " + format_value(s.rms)});
    items.push_back({"maximum " + format_value(s.maximum)});
    // If at most 1 % of the pixels are nonzero, they are easily overlooked, so the legend counts
    // them.
    if (s.nonzero * 100 <= s.values) items.push_back({"nonzero in " + pixels_text(s.nonzero)});
    add_out_of_range(plane, scale, s.values, &items);
  }
  if (s.no_value > 0) {
    items.push_back({"no value: " + pixels_text(s.no_value), colour_of(settings.colours, NAN)});
  }
  if (!settings.note.empty()) items.push_back({settings.note});
  return items;
}

ValueScale scale_of(const Plane& plane, const HeatmapSettings& settings) {
  return ValueScale(settings.range ? *settings.range
                                   : automatic_range(plane, settings.logarithmic, settings.bright),
                    settings.logarithmic);
}

// The texts of the legend, and the bar with its scale.
struct HeatmapLegend {
  std::vector<LegendItem> items;
  LegendBar bar;
};

HeatmapLegend legend_of(const Plane& plane, const HeatmapSettings& settings,
                        const ValueScale& scale) {
  const DisplayUnit unit = display_unit(settings.unit, scale.range().max);
  return {describe(plane, settings, scale, plane_statistics(plane), unit),
          {plane, scale, settings.colours, unit.factor}};
}

std::vector<LegendItem> describe(const Plane& plane, std::span<const Category> categories,
                                 const HeatmapSettings& settings) {
  std::vector<LegendItem> items = {{settings.title}};
  const uint64_t total = plane.values.size();
  uint64_t uncategorized = total;
  for (const Category& category : categories) {
    const auto count = uint64_t(std::ranges::count(plane.values, category.value));
    if (count == 0) continue;
    uncategorized -= count;
    items.push_back({category.name + ": " + share_text(count, total), category.colour});
  }
  if (uncategorized > 0)
    items.push_back({"no value: " + share_text(uncategorized, total), kNoCategory});
  return items;
}

}  // namespace

LegendLayout heatmap_layout(const Plane& plane, const HeatmapSettings& settings) {
  const HeatmapLegend legend = legend_of(plane, settings, scale_of(plane, settings));
  return lay_out_legend(plane.width, plane.height, legend.items, &legend.bar);
}

LegendLayout category_layout(const Plane& plane, std::span<const Category> categories,
                             const HeatmapSettings& settings) {
  return lay_out_legend(plane.width, plane.height, describe(plane, categories, settings), nullptr);
}

BytePicture draw_heatmap(const Plane& plane, const HeatmapSettings& settings) {
  assert(plane.width > 0 && plane.height > 0);
  const ValueScale scale = scale_of(plane, settings);
  BytePicture picture;
  if (settings.plain) {
    picture = BytePicture(plane.width, plane.height, {0, 0, 0});
  } else {
    const HeatmapLegend legend = legend_of(plane, settings, scale);
    picture = draw_legend(lay_out_legend(plane.width, plane.height, legend.items, &legend.bar),
                          &legend.bar);
  }
  paint(picture, plane,
        [&](float value) { return colour_of(settings.colours, scale.position(double(value))); });
  return picture;
}

BytePicture draw_category_map(const Plane& plane, std::span<const Category> categories,
                              const HeatmapSettings& settings) {
  assert(plane.width > 0 && plane.height > 0);
  BytePicture picture = settings.plain
                            ? BytePicture(plane.width, plane.height, kNoCategory)
                            : draw_legend(category_layout(plane, categories, settings), nullptr);
  paint(picture, plane, [&](float value) {
    const auto found = std::ranges::find(categories, value, &Category::value);
    return found == categories.end() ? kNoCategory : found->colour;
  });
  return picture;
}

}  // namespace emberline
