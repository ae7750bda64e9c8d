#include "renderer/statistics/quantity_plane.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace emberline {
namespace {

constexpr size_t kMostChannels = 8;

}  // namespace

std::string QuantityPlane::missing_channel(const HeatmapQuantity& quantity,
                                           std::span<const std::string> channels) {
  for (const std::string_view needed : quantity.channels) {
    if (std::ranges::find(channels, needed) == channels.end()) return std::string(needed);
  }
  return "";
}

std::optional<std::vector<size_t>> QuantityPlane::find_channels(
    const HeatmapQuantity& quantity, std::span<const std::string> channels) {
  std::vector<size_t> places;
  for (const std::string_view needed : quantity.channels) {
    const auto found = std::ranges::find(channels, needed);
    if (found == channels.end()) return std::nullopt;
    places.push_back(size_t(found - channels.begin()));
  }
  return places;
}

QuantityPlane::QuantityPlane(const HeatmapQuantity& quantity, std::span<const std::string> channels,
                             const Rect& crop)
    : quantity_(&quantity), channel_count_(channels.size()), crop_(crop) {
  assert(missing_channel(quantity, channels).empty() && quantity.channels.size() <= kMostChannels);
  sources_ = find_channels(quantity, channels).value();
  plane_.width = crop.width();
  plane_.height = crop.height();
  constexpr std::array<float, kMostChannels> kNoSamples{};
  plane_.values.assign(size_t(crop.area()), quantity.value(kNoSamples.data()));
}

void QuantityPlane::write_tile(const Rect& rect, std::span<const float> pixels) {
  assert(rect == rect.intersect(crop_) && pixels.size() >= size_t(rect.area()) * channel_count_);
  std::array<float, kMostChannels> values{};
  for (size_t i = 0; i < size_t(rect.area()); ++i) {
    for (size_t c = 0; c < sources_.size(); ++c)
      values[c] = pixels[i * channel_count_ + sources_[c]];
    plane_.values[crop_.index_of(rect.x_of(i), rect.y_of(i))] = quantity_->value(values.data());
  }
}

}  // namespace emberline
