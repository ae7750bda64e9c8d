#include "io/image/colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/names.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using Names = std::vector<std::string>;

// Number of names that a message lists. The limit is needed because an EXR may have thousands of
// channels.
constexpr size_t kMaxListed = 12;
constexpr size_t kMaxListedLayers = 40;  // in a message that asks the user to choose a layer

constexpr const char kUnreadPart[] =
    "{}: this part differs from the first in size or repeats channel names; save it as a "
    "separate file";

std::string join_names(const Names& names, size_t most = kMaxListed) {
  const size_t shown = std::min(names.size(), most);
  std::string text;
  for (size_t i = 0; i < shown; ++i) text += (i > 0 ? ", " : "") + shortened(names[i]);
  if (shown < names.size()) text += fmt::format(" and {} more", names.size() - shown);
  return text;
}

// Returns "sky." for "sky.R".
std::string_view layer_prefix(const std::string& channel) {
  const size_t stop = channel.rfind('.');
  return std::string_view(channel).substr(0, stop == std::string::npos ? 0 : stop + 1);
}

// Whether a channel, without its layer, has this name or the name's initial. Ignores case. OpenEXR
// files use R, and Nuke's files use red.
bool matches_name(std::string_view leaf, std::string_view name) {
  const std::string text = lower_case(std::string(leaf));
  return text == name || text == name.substr(0, 1);
}

// The channels of one layer, or the channels without a layer.
struct Layer {
  std::string prefix;  // "sky.", or empty
  const ImagePart* part = nullptr;
  std::array<int, 4> rgba = {-1, -1, -1, -1};  // indices in the part's channels; -1 if absent

  bool has_rgb() const { return std::min({rgba[0], rgba[1], rgba[2]}) >= 0; }
  std::string name() const {
    const std::string layer = prefix.empty() ? "" : prefix.substr(0, prefix.size() - 1);
    const std::string channels = layer.empty() ? "R, G, B" : layer;
    if (part->name.empty() || part->name == layer) return channels;
    return fmt::format("{} of part {}", channels, part->name);
  }
};

// Whether the layer is one of Cryptomatte's, whose channels hold ids and coverage:
// "CryptoObject00.R" or "crypto_asset01.r".
bool is_cryptomatte(const std::string& prefix) {
  const std::string name = lower_case(prefix);
  return name.find("crypto") != std::string::npos && name.size() >= 3 && name.back() == '.' &&
         name[name.size() - 2] >= '0' && name[name.size() - 2] <= '9' &&
         name[name.size() - 3] >= '0' && name[name.size() - 3] <= '9';
}

// Returns the part's layers in order of appearance.
std::vector<Layer> layers_of(const ImagePart& part) {
  constexpr std::array<std::string_view, 4> kNames = {"red", "green", "blue", "alpha"};
  std::vector<Layer> layers;
  std::map<std::string_view, size_t> known;
  for (size_t c = 0; c < part.channels.size(); ++c) {
    const std::string_view prefix = layer_prefix(part.channels[c]);
    const auto [entry, is_new] = known.try_emplace(prefix, layers.size());
    if (is_new) layers.push_back({std::string(prefix), &part});
    const std::string_view leaf = std::string_view(part.channels[c]).substr(prefix.size());
    for (size_t i = 0; i < kNames.size(); ++i) {
      int& channel = layers[entry->second].rgba[i];
      if (channel < 0 && matches_name(leaf, kNames[i])) channel = int(c);
    }
  }
  return layers;
}

std::vector<Layer> rgb_layers(const std::vector<ImagePart>& parts) {
  std::vector<Layer> found;
  for (const ImagePart& part : parts) {
    std::ranges::copy_if(layers_of(part), std::back_inserter(found), [](const Layer& layer) {
      return layer.has_rgb() && !is_cryptomatte(layer.prefix);
    });
  }
  return found;
}

// Lists those colour channels of a layer whose names differ only in case: "R, r".
std::string case_duplicates(const Layer& layer) {
  const Names& channels = layer.part->channels;
  Names found;
  for (const int c : {layer.rgba[0], layer.rgba[1], layer.rgba[2]}) {
    for (const std::string& other : channels) {
      const std::string& name = channels[size_t(c)];
      if (other != name && lower_case(other) == lower_case(name))
        found.insert(found.end(), {name, other});
    }
  }
  return join_names(found);
}

ColourChannels channels_of(const Layer& layer, const std::string& place) {
  const auto [red, green, blue, alpha] = layer.rgba;
  if (layer.part->first < 0) {
    throw InputError(place, kUnreadPart, layer.name());
  }
  if (green != red + 1 || blue != red + 2) {
    if (const std::string twice = case_duplicates(layer); !twice.empty()) {
      throw InputError(
          place, "it has channels whose names differ only in case ({}); keep only one of each",
          twice);
    }
    throw InputError(place, "the channels R, G and B are not adjacent");
  }
  return {layer.part->first + red, 3, alpha == red + 3};
}

bool is_luminance_chroma(const Names& channels) {
  return std::ranges::any_of(channels, [](const std::string& channel) {
    const std::string leaf = lower_case(channel.substr(layer_prefix(channel).size()));
    return leaf == "ry" || leaf == "by";
  });
}

// Returns the index of Y, or of R if that is the only channel. Returns -1 if there is neither, or
// if the presence of a channel X shows that Y is a coordinate.
int find_grey(const Names& channels) {
  int y = -1;
  for (size_t c = 0; c < channels.size(); ++c) {
    const std::string name = lower_case(channels[c]);
    if (name == "x") return -1;
    if (name == "y" || (channels.size() == 1 && matches_name(name, "red"))) y = int(c);
  }
  return y;
}

std::vector<ImagePart> parts_or_whole(const Names& channels, const std::vector<ImagePart>& parts) {
  return parts.empty() ? std::vector<ImagePart>{{"", channels, 0}} : parts;
}

Names all_names(const std::vector<ImagePart>& parts) {
  Names names;
  for (const ImagePart& part : parts) {
    for (const std::string& channel : part.channels) {
      names.push_back(part.first >= 0 ? channel : fmt::format("{} of part {}", channel, part.name));
    }
  }
  return names;
}

// A kind of layer, with the names of its channels. The first `required` channels must be present.
struct LayerKind {
  std::string_view letters;
  std::array<std::string_view, 4> names;
  size_t required;
};
constexpr LayerKind kLayerKinds[] = {{"RGBA", {"red", "green", "blue", "alpha"}, 3},
                                     {"XYZ", {"x", "y", "z", ""}, 2},
                                     {"UV", {"u", "v", "", ""}, 2}};

// Appends the layers that consist of the channels with this prefix.
void append_layers(const std::string& prefix, const Names& names, std::vector<int> channels,
                   std::vector<ImageLayer>& layers) {
  const std::string layer = prefix.empty() ? "" : prefix.substr(0, prefix.size() - 1);
  const bool is_single = channels.size() == 1;
  const auto leaf = [&](int c) { return std::string_view(names[size_t(c)]).substr(prefix.size()); };
  for (const auto& [letters, components, required] : kLayerKinds) {
    std::vector<int> found;
    for (size_t i = 0; i < letters.size(); ++i) {
      const std::string_view component = components[i];
      const auto channel =
          std::ranges::find_if(channels, [&](int c) { return matches_name(leaf(c), component); });
      if (channel == channels.end()) break;
      found.push_back(*channel);
    }
    if (found.size() < required) continue;
    std::erase_if(channels, [&](int c) { return std::ranges::find(found, c) != found.end(); });
    ImageLayer& added = layers.emplace_back();
    added.name = layer.empty() ? std::string(letters.substr(0, found.size())) : layer;
    added.has_colour = letters == "RGBA";
    if (found.size() == 4) {
      added.alpha = found.back();
      found.pop_back();
    }
    added.channels = std::move(found);
    break;
  }
  for (const int c : channels) {
    // "depth.Z" is called "depth" if the layer has no other channel.
    const bool is_layer = is_single && !layer.empty() && leaf(c).size() == 1;
    layers.push_back({is_layer ? layer : names[size_t(c)], {c}});
  }
}

}  // namespace

ColourChannels find_colour(const Names& channels, const std::vector<ImagePart>& parts,
                           const std::string& place, std::string_view remedy) {
  const std::vector<ImagePart> all = parts_or_whole(channels, parts);
  std::vector<Layer> layers = rgb_layers(all);
  const auto has_prefix = [](const Layer& layer) { return !layer.prefix.empty(); };
  if (!std::ranges::all_of(layers, has_prefix)) std::erase_if(layers, has_prefix);
  if (layers.size() == 1) return channels_of(layers.front(), place);
  if (layers.size() > 1) {
    Names names;
    std::ranges::transform(layers, std::back_inserter(names), &Layer::name);
    throw InputError(place, "{} layers have R, G and B; {}: {}", names.size(), remedy,
                     join_names(names));
  }
  if (is_luminance_chroma(channels)) {
    throw InputError(place, "luminance-chroma EXR is not supported; save it as RGB");
  }
  const int grey = find_grey(channels);
  if (grey < 0) {
    throw InputError(
        place, "it has neither channels R, G and B nor a single channel Y; its channels are {}",
        join_names(all_names(all)));
  }
  const size_t next = size_t(grey) + 1;
  return {grey, 1, next < channels.size() && matches_name(channels[next], "alpha")};
}

std::vector<ImageLayer> image_layers(const Names& channels, const std::vector<ImagePart>& parts) {
  std::vector<ImageLayer> layers;
  for (const ImagePart& part : parts_or_whole(channels, parts)) {
    if (part.first < 0) continue;
    std::vector<std::pair<std::string, std::vector<int>>> groups;  // by prefix
    std::map<std::string_view, size_t> known;
    for (size_t i = 0; i < part.channels.size(); ++i) {
      const size_t c = size_t(part.first) + i;
      if (c >= channels.size()) break;
      const std::string_view prefix = layer_prefix(channels[c]);
      const auto [entry, is_new] = known.try_emplace(prefix, groups.size());
      if (is_new) groups.emplace_back(prefix, std::vector<int>{});
      groups[entry->second].second.push_back(int(c));
    }
    for (const auto& [prefix, members] : groups) append_layers(prefix, channels, members, layers);
  }
  return layers;
}

std::optional<ImageLayer> try_find_layer(const Names& channels, const std::vector<ImagePart>& parts,
                                         const std::string& name, const std::string& place) {
  const std::vector<ImageLayer> layers = image_layers(channels, parts);
  const auto is_picture = [](std::string_view word) { return word == "RGB" || word == "RGBA"; };
  for (const ImageLayer& layer : layers) {
    if (layer.name == name || (is_picture(name) && is_picture(layer.name))) return layer;
  }
  const auto channel = std::ranges::find(channels, name);
  if (channel != channels.end()) return ImageLayer{name, {int(channel - channels.begin())}};
  for (const ImagePart& part : parts) {
    if (part.name != name || name.empty()) continue;
    if (part.first < 0) throw InputError(place, kUnreadPart, name);
    const auto in_part = [&](const ImageLayer& layer) {
      const int c = layer.channels.front() - part.first;
      return c >= 0 && c < int(part.channels.size());
    };
    const auto layer = std::ranges::find_if(layers, in_part);
    if (layer != layers.end()) return *layer;
  }
  return std::nullopt;
}

ImageLayer find_layer(const Names& channels, const std::vector<ImagePart>& parts,
                      const std::string& name, const std::string& place) {
  if (auto found = try_find_layer(channels, parts, name, place)) return *std::move(found);
  const std::vector<ImageLayer> layers = image_layers(channels, parts);
  std::vector<std::string_view> names;
  for (const ImageLayer& layer : layers) names.push_back(layer.name);
  Names listed;
  for (const size_t i : nearest_indices(name, names)) listed.push_back(layers[i].name);
  for (const ImageLayer& layer : layers) {
    if (std::ranges::find(listed, layer.name) == listed.end()) listed.push_back(layer.name);
  }
  throw UsageError("`layer`: unknown layer '{}'; the layers in {}, closest match first, are {}",
                   shortened(name), place, join_names(listed, kMaxListedLayers));
}

bool is_cube_map(const std::vector<ImagePart>& parts, int channel) {
  return std::ranges::any_of(parts, [channel](const ImagePart& part) {
    return part.cube && part.first >= 0 && channel >= part.first &&
           channel < part.first + int(part.channels.size());
  });
}

}  // namespace emberline
