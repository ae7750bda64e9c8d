#include "renderer/session/picture_files.h"

#include <algorithm>
#include <memory>

#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/output/heatmap_file.h"
#include "renderer/output/outputs.h"
#include "renderer/output/report.h"
#include "renderer/session/overlay_picture.h"

namespace emberline {

void write_picture(const std::string& path, const FilmCopy& film, const DisplaySettings& display) {
  if (lower_suffix(path) == ".exr") {
    write_film_exr(path, film.aovs, film.options.width, film.options.height, film.crop,
                   settings_attributes(film.options), film.channels);
    return;
  }
  const size_t channels = film_channels(film.aovs).size(), pixels = film.channels.size() / channels;
  std::vector<float> rgba(4 * pixels);
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&film.channels[channels * i], 4, &rgba[4 * i]);
  write_display_image(path, film.crop, std::make_shared<DisplayTransform>(display),
                      film.options.transparent, rgba);
}

const HeatmapQuantity& heatmap_of(ViewOverlay overlay) {
  const HeatmapQuantity* quantity = overlay_quantity(overlay);
  if (!quantity) throw UsageError("this overlay is no heatmap; save the picture instead");
  return *quantity;
}

void write_heatmap(const std::string& path, const FilmCopy& film, ViewOverlay overlay) {
  const HeatmapQuantity& quantity = heatmap_of(overlay);
  const Rect& crop = film.crop;
  check_heatmap_format("heatmap", path, crop);
  // Stop reasons are known without the channel, and while the frame goes on.
  const bool reasons = quantity.reasons && !film.stops.empty();
  const std::vector<std::string> names =
      reasons ? std::vector<std::string>{"stop"} : film_channel_names(film.aovs);
  const std::string missing = QuantityPlane::missing_channel(quantity, names);
  if (!missing.empty()) {
    throw RenderError(path + ": the frame was rendered without the channel " + missing +
                      "; show that overlay, then save it");
  }
  HeatmapFile file(
      {path, &quantity}, film.options.heatmap_style,
      {film.options.width, film.options.height, crop, settings_attributes(film.options)}, names);
  file.write_tile(crop, reasons ? film.stops : film.channels);
  file.finish();
}

}  // namespace emberline
