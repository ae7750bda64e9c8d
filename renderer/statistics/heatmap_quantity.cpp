#include "renderer/statistics/heatmap_quantity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <iterator>

#include "renderer/core/display_error.h"
#include "renderer/core/names.h"
#include "renderer/core/setting_names.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {
namespace {

// `channels` are samples, R, G, B, and the variances of R, G and B.
float display_error(const float* channels) {
  const float samples = channels[0], *mean = channels + 1, *variance = channels + 4;
  if (!(samples >= 2.0f)) return NAN;
  float sum = 0.0f;
  for (size_t c = 0; c < 3; ++c) {
    sum += variance[c] * display_error_weight(mean[c], std::sqrt(variance[c]), 0.0f);
  }
  return std::sqrt(sum * (1.0f / 3));
}

// Returns a quantity that is one of the channels of the AOV `rays`.
HeatmapQuantity ray_quantity(std::string_view name, std::string_view summary,
                             std::string_view title) {
  return {.name = name, .summary = summary, .title = title, .aov = Aov::kRays, .channels = {name}};
}

}  // namespace

std::span<const HeatmapQuantity> heatmap_quantity_table() {
  // If a thread is interrupted, the pause is added to the time of the pixel that the thread is
  // sampling. On a busy machine, this affects more than one pixel in a hundred, so the bright end
  // must be a lower quantile than usual.
  constexpr double kTimeBright = 0.95;
  static const std::vector<HeatmapQuantity> table = {
      {.name = "samples",
       .summary = "samples per pixel; brighter means more",
       .title = "samples per pixel",
       .channels = {"samples"}},
      {.name = "error",
       .summary =
           "estimated RMS error of the pixel, from its own samples only, as displayed (sRGB, "
           "0 to 1)",
       .title = "estimated error, RMS as displayed (0 to 1)",
       .aov = Aov::kVariance,
       .channels = {"samples", "R", "G", "B", "variance.R", "variance.G", "variance.B"},
       .value = display_error,
       .note = "estimated from each pixel's own samples only; the driver compares "
               "`noise-threshold` with a different error, so the maximum here can exceed the "
               "threshold",
       .rms = true},
      {.name = "denoised_error",
       .summary = "estimated error of the denoised picture; needs a finished .exr",
       .title = "estimated error when denoised, RMS as displayed (0 to 1)",
       .channels = {"denoised.error"},
       .needs_denoised = true,
       .rms = true},
      {.name = "stop",
       .summary = "why each pixel got no more samples",
       .title = "why each pixel stopped",
       .aov = Aov::kStop,
       .channels = {"stop"},
       .value = [](const float* all) { return std::fmod(all[0], float(kStopReasons)); },
       .categories =
           [](const HeatmapStyle&) {
             return std::vector<Category>(stop_categories().begin(), stop_categories().end());
           }},
      {.name = "judge",
       .summary = "the channel of `judge` that needed each pixel's last samples",
       .title = "channel that needed the last samples",
       .aov = Aov::kStop,
       .channels = {"stop"},
       .value = [](const float* all) { return std::floor(all[0] / float(kStopReasons)); },
       .categories = judged_categories},
      {.name = "time",
       .summary = "time spent on each pixel",
       .title = "time per pixel",
       .unit = "s",
       .aov = Aov::kTime,
       .channels = {"time"},
       .bright = kTimeBright},
      {.name = "non_finite",
       .summary = "samples that were NaN or infinite",
       .title = "NaN or infinite samples per pixel",
       .aov = Aov::kNonFinite,
       .channels = {"non_finite"}},
      {.name = "part",
       .summary = "the part of a merged frame that each pixel comes from",
       .title = "part of the frame",
       .aov = Aov::kPart,
       .channels = {"part"}},
      {.name = "rays",
       .summary = "rays traced for each pixel",
       .title = "rays per pixel",
       .aov = Aov::kRays,
       .channels = {"rays.camera", "rays.scatter", "rays.shadow"},
       .value = [](const float* channels) { return channels[0] + channels[1] + channels[2]; }},
      ray_quantity("rays.camera", "camera rays for each pixel", "camera rays per pixel"),
      ray_quantity("rays.scatter", "rays that continue paths, for each pixel",
                   "continued paths per pixel"),
      ray_quantity("rays.shadow", "shadow rays for each pixel", "shadow rays per pixel"),
  };
  return table;
}

const HeatmapQuantity& find_heatmap_quantity(std::string_view name, std::string_view option) {
  return find_named(heatmap_quantity_table(), option, "quantity", name);
}

std::span<const Category> stop_categories() {
  const auto category = [](PixelStop stop, const Rgb8& colour) {
    return Category{float(stop), pixel_stop_name(stop), colour};
  };
  static const std::vector<Category> categories = {
      {float(PixelStop::kNone), "no sample", {0, 0, 0}},
      {float(PixelStop::kBudget), spell_setting_names("`spp` or `plan`"), {0, 114, 178}},
      category(PixelStop::kThreshold, {86, 180, 233}),
      category(PixelStop::kMaximum, {240, 228, 66}),
      category(PixelStop::kTimeLimit, {204, 121, 167}),
      category(PixelStop::kUser, {213, 94, 0}),
      category(PixelStop::kUnfinished, {72, 72, 72}),
      category(PixelStop::kTimeBudget, {150, 210, 160}),
  };
  return categories;
}

std::vector<Category> judged_categories(const HeatmapStyle& style) {
  // The colours are from Okabe & Ito 2008, and repeat after eight channels.
  constexpr Rgb8 kColours[] = {{0, 114, 178},  {230, 159, 0}, {0, 158, 115},  {204, 121, 167},
                               {86, 180, 233}, {213, 94, 0},  {240, 228, 66}, {153, 153, 153}};
  std::vector<Category> categories;
  for (size_t k = 0; k < kMaxJudged; ++k) {
    const std::string name =
        k < style.judged.size() ? style.judged[k] : fmt::format("channel {}", k + 1);
    categories.push_back({float(k), name, kColours[k % std::size(kColours)]});
  }
  return categories;
}

BytePicture draw_quantity(const HeatmapQuantity& quantity, const Plane& plane,
                          const HeatmapStyle& style) {
  const HeatmapSettings settings{
      style,        std::string(quantity.title),       std::string(quantity.unit), quantity.bright,
      quantity.rms, spell_setting_names(quantity.note)};
  return quantity.categories ? draw_category_map(plane, quantity.categories(style), settings)
                             : draw_heatmap(plane, settings);
}

std::string QuantityPlane::missing_channel(const HeatmapQuantity& quantity,
                                           std::span<const std::string> channels) {
  for (const std::string_view needed : quantity.channels) {
    if (std::ranges::find(channels, needed) == channels.end()) return std::string(needed);
  }
  return "";
}

std::optional<std::vector<size_t>> QuantityPlane::find_channels(
    const HeatmapQuantity& quantity, std::span<const std::string> channels) {
  std::vector<size_t> indices;
  for (const std::string_view needed : quantity.channels) {
    const auto found = std::ranges::find(channels, needed);
    if (found == channels.end()) return std::nullopt;
    indices.push_back(size_t(found - channels.begin()));
  }
  return indices;
}

QuantityPlane::QuantityPlane(const HeatmapQuantity& quantity, std::span<const std::string> channels,
                             const Rect& crop)
    : quantity_(&quantity), crop_(crop) {
  assert(missing_channel(quantity, channels).empty() && quantity.channels.size() <= kMaxChannels);
  sources_ = find_channels(quantity, channels).value();
  plane_.width = crop.width();
  plane_.height = crop.height();
  constexpr std::array<float, kMaxChannels> kNoSamples{};
  plane_.values.assign(size_t(crop.area()), quantity.value(kNoSamples.data()));
}

void QuantityPlane::write_tile(const Rect& rect, std::span<const float> pixels) {
  const size_t stride = pixels.size() / size_t(rect.area());
  assert(rect == rect.intersect(crop_) && std::ranges::max(sources_) < stride);
  std::array<float, kMaxChannels> values{};
  for (size_t i = 0; i < size_t(rect.area()); ++i) {
    for (size_t c = 0; c < sources_.size(); ++c) values[c] = pixels[i * stride + sources_[c]];
    plane_.values[crop_.index_of(rect.x_of(i), rect.y_of(i))] = quantity_->value(values.data());
  }
}

}  // namespace emberline
