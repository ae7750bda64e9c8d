#include "renderer/engine/half_layers.h"

#include <algorithm>

#include "io/exr/writer.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/film/channels.h"

namespace emberline {
std::span<const HalfLayer> half_layer_table() {
  static const std::vector<HalfLayer> table = [] {
    std::vector<HalfLayer> layers;
    for (const ChannelRow& row : channel_table()) {
      if (!may_be_half(row.use)) continue;
      layers.push_back({row.name, row.setting == "aov" ? "see `aov`" : row.summary});
    }
    return layers;
  }();
  return table;
}

std::vector<std::string> parse_half_layers(std::string_view list) {
  std::vector<std::string> layers;
  for (const std::string_view name : split_list(list)) {
    layers.emplace_back(find_named(half_layer_table(), "`half`", "layer", name).name);
  }
  return layers;
}

bool is_half(std::string_view channel, const std::vector<std::string>& layers) {
  const std::string layer_name = layer_of(std::string(channel));
  return std::ranges::any_of(layers, [&](const std::string& layer) {
    return layer_name == layer || layer_name.starts_with(layer + ".");
  });
}

}  // namespace emberline
