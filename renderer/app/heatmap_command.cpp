#include "renderer/app/commands.h"

#include "io/files/register.h"
#include "io/image/input.h"
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

}  // namespace

int run_heatmap(const HeatmapOptions& options) {
  const WorkerThreads workers(0);
  const HeatmapQuantity& quantity = find_heatmap_quantity(options.quantity, "--of");
  const HeatmapQuantity* const quantities[] = {&quantity};
  check_heatmap_style(options.style, quantities);
  check_heatmap_format("-o", options.output, {});
  FileRegister files;
  files.read(options.image, "it is the picture itself");
  files.write("-o", options.output);
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  const FloatImage image = read_frame(options.image, progress);
  check_heatmap_channels(options.image, quantity, image.channel_names);
  const Rect& crop = image.data_window;
  check_heatmap_format("-o", options.output, crop);
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
