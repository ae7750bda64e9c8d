#include "renderer/api/picture_sink.h"

#include <algorithm>
#include <utility>

#include "renderer/core/memory_budget.h"
#include "renderer/output/denoise_pass.h"

namespace emberline::api {
namespace {

FrameChannels channels_of(const OutputSettings& settings) {
  return {settings.aovs, settings.light_groups, settings.cryptomattes, settings.cryptomatte_levels};
}

}  // namespace

PictureSink::PictureSink(const OutputSettings& settings, const SceneLayers& layers)
    : settings_(settings), channels_(channels_of(settings)) {
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
  tile.resolve(pixels);
  channels_.append(tile, pixels);
  put_tile(tile.rect(), pixels, settings_.crop, picture_.values);
}

Picture PictureSink::finish(const std::stop_token& stop) {
  picture_.channels = std::move(names_);
  finish_film(settings_.crop, settings_.tile_size, settings_.denoise, picture_.channels,
              picture_.values, stop);
  return std::move(picture_);
}

uint64_t PictureSink::bytes(const OutputSettings& settings, const SceneLayers& layers) {
  FrameChannels channels = channels_of(settings);
  channels.add_scene(layers);
  const std::vector<std::string> summed = names_of(summed_channels(channels.list()));
  size_t count = channels.list().size();
  if (settings.denoise) count += summed.size() + denoise_results(summed).size();
  return bytes_of(uint64_t(settings.crop.area()), count * sizeof(float));
}

}  // namespace emberline::api
