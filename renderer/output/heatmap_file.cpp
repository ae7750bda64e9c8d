#include "renderer/output/heatmap_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/engine/render_plan.h"

namespace emberline {

void check_heatmap_format(const std::string& option, const std::string& path, const Rect& crop) {
  if (is_exr(path)) return;
  std::string format;
  try {
    format = image_format_of(path);
  } catch (const UsageError&) {
    throw UsageError("{} {}: unknown format; valid suffixes are .exr, .png, .jpg, .jpeg", option,
                     path);
  }
  // libjpeg's limit is 65500 pixels per side (JPEG_MAX_DIMENSION). kJpegLimit is lower, to leave
  // room for the legend, whose size grows with that of the frame.
  constexpr int kJpegLimit = 50000;
  if (format == "jpeg" && std::max(crop.width(), crop.height()) > kJpegLimit) {
    throw UsageError("{} {}: JPEG holds heatmaps of at most {} pixels a side; write .exr or .png",
                     option, path, kJpegLimit);
  }
}

void check_heatmap_style(const HeatmapStyle& style,
                         std::span<const HeatmapQuantity* const> quantities) {
  constexpr double kMinLogRange = 1e-30;
  if (style.range && style.logarithmic && !(style.range->min >= kMinLogRange)) {
    throw UsageError("`range`: with `log` the range must begin at {} or more, not at {}",
                     kMinLogRange, style.range->min);
  }
  const HeatmapQuantity* amounts = nullptr;
  for (const HeatmapQuantity* quantity : quantities) {
    if (quantity->categories) continue;
    if (style.range && amounts && amounts != quantity) {
      throw UsageError(
          "`range`: the same range cannot suit both {} and {}; after the render, make one of the "
          "heatmaps from the .exr with emberline heatmap",
          amounts->name, quantity->name);
    }
    amounts = quantity;
  }
  if (!amounts && (style.range || style.logarithmic)) {
    throw UsageError("{}: {} shows reasons, which have no scale", style.range ? "`range`" : "`log`",
                     quantities.front()->name);
  }
}

std::vector<std::string> judged_names(const FrameSettings& settings) {
  std::vector<std::string> names;
  if (!settings.plan.empty()) return names;  // the plan decided the sample counts
  for (const JudgedChannel& channel : judged_channels_of(settings)) names.push_back(channel.name);
  return names;
}

bool is_valid_heatmap_range(double min, double max) {
  constexpr double kMaxMagnitude = 1e18, kMinMagnitude = 1e-30, kMinRelativeWidth = 1e-6;
  const double greatest = std::max(std::abs(min), std::abs(max));
  return greatest <= kMaxMagnitude && greatest >= kMinMagnitude &&
         max - min >= kMinRelativeWidth * greatest;
}

void check_heatmap_channels(const std::string& place, const HeatmapQuantity& quantity,
                            std::span<const std::string> channels) {
  const std::string missing = QuantityPlane::missing_channel(quantity, channels);
  if (missing.empty()) return;
  const std::string remedy =
      quantity.needs_denoised
          ? std::string("render it with `denoise`, or run emberline denoise on it")
      : quantity.aov ? fmt::format("render it with `aov` {}", name_of(aov_table(), *quantity.aov))
                     : std::string("use an .exr that `emberline render` wrote");
  throw InputError(place, "it has no channel named \"{}\", which a heatmap of {} needs; {}",
                   missing, quantity.name, remedy);
}

std::vector<HeatmapRequest> heatmap_requests(const RenderOptions& options) {
  if (options.heatmap_of.size() > options.heatmaps.size()) {
    throw UsageError(
        "`heatmap-of` {}: no `heatmap` belongs to it; give both options the same number of times, "
        "in the same order",
        options.heatmap_of[options.heatmaps.size()]);
  }
  std::vector<HeatmapRequest> requests;
  std::vector<const HeatmapQuantity*> quantities;
  for (size_t i = 0; i < options.heatmaps.size(); ++i) {
    const HeatmapQuantity& quantity = i < options.heatmap_of.size()
                                          ? find_heatmap_quantity(options.heatmap_of[i])
                                          : heatmap_quantity_table().front();
    if (quantity.needs_denoised) {
      throw UsageError(
          "`heatmap-of` {0}: a frame is denoised only at the end; afterwards, use emberline "
          "heatmap FILE.exr `of` {0}",
          quantity.name);
    }
    requests.push_back({options.heatmaps[i], &quantity});
    quantities.push_back(&quantity);
  }
  if (!requests.empty()) check_heatmap_style(options.heatmap_style, quantities);
  return requests;
}

HeatmapFile::HeatmapFile(const HeatmapRequest& request, const HeatmapStyle& style,
                         const Frame& frame, std::span<const std::string> channels)
    : path_(request.path), style_(style), plane_(*request.quantity, channels, frame.crop) {
  if (is_exr(request.path)) {
    const ExrHeader header = {.width = frame.width,
                              .height = frame.height,
                              .data_window = frame.crop,
                              .channels = {{std::string(request.quantity->name)}},
                              .attributes = frame.attributes};
    exr_ = std::make_unique<ExrWriter>(request.path, header);
  } else {
    picture_.emplace(request.path);
  }
}

void HeatmapFile::finish() {
  if (exr_) {
    exr_->write(plane_.plane().values);
    return exr_->finish();
  }
  const BytePicture image = draw_quantity(plane_.quantity(), plane_.plane(), style_);
  const std::vector<unsigned char> bytes = encode_image(image, image_format_of(path_), path_);
  picture_->write_at(bytes.data(), bytes.size(), 0);
  picture_->commit();
}

}  // namespace emberline
