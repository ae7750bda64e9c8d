#include <algorithm>
#include <cmath>

#include "io/files/register.h"
#include "io/image/input.h"
#include "renderer/app/commands.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/heatmap_file.h"
#include "renderer/output/recorded_settings.h"
#include "renderer/output/rgb_file.h"

namespace emberline {
namespace {

FrameSettings settings_of_file(const std::string& path) {
  const RecordedSettings recorded(FloatImageRows(path).text_attributes());
  FrameSettings settings = recorded.settings();
  settings.plan = recorded.text("plan");
  return settings;
}

// The values of a frame's pixels.
Plane plane_of(const std::string& path, const FloatImage& frame, std::string_view name) {
  const HeatmapQuantity& quantity = find_heatmap_quantity(name);
  check_heatmap_channels(path, quantity, frame.channel_names);
  QuantityPlane plane(quantity, frame.channel_names, frame.data_window);
  plane.write_tile(frame.data_window, frame.values);
  return plane.plane();
}

// Returns squared error times time, in proportion to the time for an equal error. NaN where a pixel
// has no error.
Plane costs_of(const std::string& path, const FloatImage& frame) {
  Plane costs = plane_of(path, frame, "error");
  const Plane time = plane_of(path, frame, "time");
  for (size_t i = 0; i < costs.values.size(); ++i) {
    costs.values[i] *= costs.values[i] * time.values[i];
  }
  return costs;
}

// Divides the sums over the pixels around each pixel, because the estimates for single pixels are
// noisy. Pixels that lack a value in one of the planes are left out.
std::vector<float> local_ratios(const Plane& above, const Plane& below) {
  constexpr int kRadius = 2;
  std::vector<float> ratios;
  for (int y = 0; y < below.height; ++y) {
    for (int x = 0; x < below.width; ++x) {
      float sum_above = 0.0f, sum_below = 0.0f;
      for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, below.height - 1); ++v) {
        for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, below.width - 1); ++u) {
          if (!std::isfinite(above.at(u, v)) || !std::isfinite(below.at(u, v))) continue;
          sum_above += above.at(u, v);
          sum_below += below.at(u, v);
        }
      }
      ratios.push_back(sum_below > 0.0f ? sum_above / sum_below : NAN);
    }
  }
  return ratios;
}

// The heatmap of --against.
const HeatmapQuantity kSaving = {.name = "saving",
                                 .summary = "",
                                 .title = "times less time to an equal error",
                                 .channels = {"saving"}};

}  // namespace

int run_heatmap(const HeatmapOptions& options) {
  const WorkerThreads workers(0);
  const bool compares = !options.against.empty();
  const HeatmapQuantity& quantity =
      compares ? kSaving : find_heatmap_quantity(options.quantity, "--of");
  const HeatmapQuantity* const quantities[] = {&quantity};
  check_heatmap_style(options.style, quantities);
  check_heatmap_format("-o", options.output, {});
  FileRegister files;
  files.read(options.image, "it is the picture itself");
  if (compares) files.read(options.against, "it is the picture of --against");
  files.write("-o", options.output);
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  FloatImage image = read_frame(options.image, progress);
  const Rect crop = image.data_window;
  check_heatmap_format("-o", options.output, crop);
  if (compares) {
    const FloatImage other = read_frame(options.against, progress);
    if (other.frame_width != image.frame_width || other.frame_height != image.frame_height ||
        other.data_window != crop) {
      throw InputError(options.against, "its size or crop is not that of {}", options.image);
    }
    image.values = local_ratios(costs_of(options.against, other), costs_of(options.image, image));
    image.channel_names = {std::string(kSaving.name)};
  }
  check_heatmap_channels(options.image, quantity, image.channel_names);
  HeatmapStyle style = options.style;
  if (quantity.aov == Aov::kStop) style.judged = judged_names(settings_of_file(options.image));
  HeatmapFile file(
      {options.output, &quantity}, style,
      {image.frame_width, image.frame_height, crop, {{"emberline.image", options.image}}},
      image.channel_names);
  file.write_tile(crop, image.values);
  file.finish();
  log_info("wrote " + options.output);
  return kExitDone;
}

}  // namespace emberline
