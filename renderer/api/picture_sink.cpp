#include "renderer/api/picture_sink.h"

#include <utility>

#include "renderer/core/memory_budget.h"
#include "renderer/core/rect_values.h"
#include "renderer/output/denoise_pass.h"

namespace emberline::api {
PictureSink::PictureSink(const OutputSettings& settings, const SceneLayers& layers)
    : settings_(settings), channels_(settings) {
  channels_.add_scene(layers);
  names_ = names_of(channels_.list());
  const Rect& crop = settings.crop;
  picture_.width = crop.width();
  picture_.height = crop.height();
  picture_.x = crop.x0;
  picture_.y = crop.y0;
  picture_.frame_width = settings.width;
  picture_.frame_height = settings.height;
  picture_.values.resize(size_t(crop.area()) * names_.size());
}

void PictureSink::tile_finished(const FilmTile& tile) {
  std::vector<float> pixels;
  channels_.resolve(tile, pixels);
  put_rect(pixels, tile.rect(), settings_.crop, picture_.values);
}

Picture PictureSink::finish(const std::stop_token& stop) {
  picture_.channels = std::move(names_);
  finish_film(settings_.crop, settings_.tile_size, settings_.denoise, picture_.channels,
              picture_.values, stop);
  return std::move(picture_);
}

uint64_t PictureSink::bytes(const OutputSettings& settings, const SceneLayers& layers) {
  const std::vector<PictureChannel> channels = tile_channels(settings, layers.lights);
  size_t count = channels.size();
  if (settings.denoise) count += finished_channels(channels, true).size();
  return bytes_of(uint64_t(settings.crop.area()), count * sizeof(float));
}

}  // namespace emberline::api
