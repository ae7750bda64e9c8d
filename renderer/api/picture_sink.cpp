#include "renderer/api/picture_sink.h"

#include <algorithm>
#include <utility>

#include "renderer/core/memory_budget.h"
#include "renderer/film/shared_samples.h"
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
  if (settings_.denoise) {
    denoise(stop);
  } else {
    sum_shared(settings_.crop, picture_.channels, picture_.values);
  }
  return std::move(picture_);
}

void PictureSink::denoise(const std::stop_token& stop) {
  const Rect& crop = settings_.crop;
  const size_t stride = picture_.channels.size();
  SharedRows rows(crop, picture_.channels, [&](const Rect& part, std::vector<float>& pixels) {
    const auto first =
        picture_.values.begin() + ptrdiff_t(crop.index_of(part.x0, part.y0) * stride);
    pixels.assign(first, first + ptrdiff_t(size_t(part.area()) * stride));
  });
  std::vector<std::string> names = with_shared_sums(picture_.channels);
  const std::vector<std::string> results = denoise_results(names);
  std::vector<float> denoised(size_t(crop.area()) * (names.size() + results.size()));
  denoise_frame(
      {.crop = crop,
       .channels = names,
       .tile_size = settings_.tile_size,
       .read = [&](const Rect& part, std::vector<float>& pixels) { rows.read(part, pixels); },
       .write = [&](const Rect& tile,
                    const std::vector<float>& pixels) { put_tile(tile, pixels, crop, denoised); },
       .stop = stop});
  names.insert(names.end(), results.begin(), results.end());
  picture_.channels = std::move(names);
  picture_.values = std::move(denoised);
}

uint64_t PictureSink::bytes(const OutputSettings& settings, const SceneLayers& layers) {
  FrameChannels channels = channels_of(settings);
  channels.add_scene(layers);
  const std::vector<std::string> names = names_of(channels.list());
  size_t count = names.size();
  if (settings.denoise) count += with_shared_sums(names).size() + denoise_results(names).size();
  return bytes_of(uint64_t(settings.crop.area()), count * sizeof(float));
}

}  // namespace emberline::api
