#include "renderer/output/frame_channels.h"

#include <algorithm>

#include "renderer/film/shared_samples.h"
#include "renderer/output/denoise_pass.h"
#include "renderer/output/light_layers.h"

namespace emberline {

std::vector<PictureChannel> tile_channels(const FrameContents& contents,
                                          const std::vector<std::string>& light_layers) {
  std::vector<PictureChannel> channels = film_channels(contents.aovs);
  if (contents.light_groups) {
    for (auto& name : light_channel_names(light_layers, contents.aovs)) channels.push_back({name});
  }
  for (auto& name : cryptomatte_channel_names(contents.cryptomattes, contents.cryptomatte_levels)) {
    channels.push_back({name});
  }
  return channels;
}

std::vector<PictureChannel> finished_channels(const std::vector<PictureChannel>& of_tile,
                                              bool denoised) {
  const std::vector<std::string> names = names_of(of_tile);
  std::vector<PictureChannel> channels;
  for (const std::string& name : resolved_channel_names(names)) {
    const auto same = std::ranges::find(of_tile, name, &PictureChannel::name);
    channels.push_back(same != of_tile.end() ? *same : PictureChannel{name});
  }
  if (!denoised) return channels;
  for (const std::string& name : denoise_results(names)) channels.push_back({name});
  return channels;
}

FrameChannels::FrameChannels(const FrameContents& contents)
    : contents_(contents),
      film_channel_count_(film_channels(contents.aovs).size()),
      list_(tile_channels(contents, {})),
      mattes_(contents.cryptomattes.size()) {}

void FrameChannels::add_scene(const SceneLayers& layers) {
  list_ = tile_channels(contents_, layers.lights);
  for (size_t i = 0; i < std::min(mattes_.size(), layers.cryptomattes.size()); ++i) {
    mattes_[i] = {layers.cryptomattes[i].kind, layers.cryptomattes[i].ids.size()};
  }
}

void FrameChannels::resolve(const FilmTile& tile, std::vector<float>& pixels) {
  tile.resolve(pixels, list_.size() - film_channel_count_);
  std::vector<CryptomatteReport> of_tile(mattes_.size());
  std::vector<CryptomatteSums::Rank> ranks;
  for (size_t i = 0; list_.size() > film_channel_count_ && i < size_t(tile.rect().area()); ++i) {
    float* values = &pixels[i * list_.size() + film_channel_count_];
    if (contents_.light_groups) values = put_light_layers(tile, i, values);
    put_cryptomattes(tile, i, values, ranks, of_tile);
  }
  const std::lock_guard lock(mutex_);
  for (size_t kind = 0; kind < of_tile.size(); ++kind) mattes_[kind].merge(of_tile[kind]);
}

std::vector<CryptomatteReport> FrameChannels::mattes() const {
  const std::lock_guard lock(mutex_);
  return mattes_;
}

}  // namespace emberline
