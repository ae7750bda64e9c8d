#include "renderer/output/frame_channels.h"

#include <algorithm>
#include <utility>

#include "renderer/film/shared_samples.h"
#include "renderer/output/light_layers.h"

namespace emberline {

std::vector<ExrChannel> exr_channels(const AovSet& aovs) {
  std::vector<ExrChannel> channels;
  for (const FilmChannel& channel : film_channels(aovs)) {
    channels.push_back({channel.name, channel.integer ? ChannelType::kUint : ChannelType::kFloat});
  }
  return channels;
}

std::vector<std::string> names_of(const std::vector<ExrChannel>& channels) {
  std::vector<std::string> names;
  for (const ExrChannel& channel : channels) names.push_back(channel.name);
  return names;
}

std::vector<ExrChannel> summed_channels(const std::vector<ExrChannel>& channels) {
  std::vector<ExrChannel> summed;
  for (const std::string& name : with_shared_sums(names_of(channels))) {
    const auto same = std::ranges::find(channels, name, &ExrChannel::name);
    summed.push_back(same != channels.end() ? *same : ExrChannel{name});
  }
  return summed;
}

FrameChannels::FrameChannels(const AovSet& aovs, bool light_groups,
                             std::vector<CryptomatteKind> mattes, int matte_levels)
    : aovs_(aovs),
      light_groups_(light_groups),
      matte_kinds_(std::move(mattes)),
      matte_levels_(matte_levels),
      list_(exr_channels(aovs)),
      mattes_(matte_kinds_.size()) {}

void FrameChannels::add_scene(const SceneLayers& layers) {
  const auto add = [this](const std::vector<std::string>& names) {
    for (const std::string& name : names) list_.push_back({name});
  };
  if (light_groups_) add(light_channel_names(layers.lights, aovs_));
  add(cryptomatte_channel_names(matte_kinds_, matte_levels_));
  for (size_t i = 0; i < std::min(mattes_.size(), layers.cryptomattes.size()); ++i) {
    mattes_[i] = {layers.cryptomattes[i].kind, layers.cryptomattes[i].ids.size()};
  }
}

void FrameChannels::append(const FilmTile& tile, std::vector<float>& pixels) {
  if (light_groups_) append_light_layers(tile, pixels);
  if (matte_kinds_.empty()) return;
  std::vector<CryptomatteReport> of_tile(matte_kinds_.size());
  append_cryptomattes(tile, pixels, of_tile);
  const std::lock_guard lock(mutex_);
  for (size_t kind = 0; kind < of_tile.size(); ++kind) mattes_[kind].merge(of_tile[kind]);
}

std::vector<CryptomatteReport> FrameChannels::mattes() const {
  const std::lock_guard lock(mutex_);
  return mattes_;
}

void put_tile(const Rect& tile, std::span<const float> pixels, const Rect& frame,
              std::span<float> values) {
  const size_t channels = pixels.size() / size_t(tile.area());
  const size_t row = size_t(tile.width()) * channels;
  for (int y = tile.y0; y < tile.y1; ++y) {
    std::copy_n(&pixels[size_t(y - tile.y0) * row], row,
                &values[frame.index_of(tile.x0, y) * channels]);
  }
}

}  // namespace emberline
