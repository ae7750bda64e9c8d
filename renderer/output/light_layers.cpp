#include "renderer/output/light_layers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <set>

#include "renderer/film/film.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/light_group_sums.h"

namespace emberline {
namespace {

// EXR names have at most 255 bytes. A prefix, a number and the name of a channel may be added to
// the group's name.
constexpr size_t kMaxNameLength = 200;

std::string safe_name(const std::string& name) {
  std::string safe = name.substr(0, kMaxNameLength);
  std::ranges::replace_if(
      safe,
      [](char c) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        return !letter && !(c >= '0' && c <= '9') && c != '-' && c != '_';
      },
      '_');
  return safe;
}

}  // namespace

std::vector<std::string> light_layer_names(std::span<const LightGroup> groups) {
  std::vector<std::string> names;
  std::set<std::string> used_names;
  for (size_t i = 0; i < groups.size(); ++i) {
    const std::string base = "light." + safe_name(groups[i].name);
    std::string name = groups[i].name.empty() ? fmt::format("{}{}", base, i) : base;
    for (int number = 2; !used_names.insert(name).second; ++number) {
      name = fmt::format("{}_{}", base, number);
    }
    names.push_back(std::move(name));
  }
  return names;
}

std::vector<std::string> light_channel_names(const std::vector<std::string>& layers,
                                             const AovSet& aovs) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& begin) {
    for (const std::string& layer : layers) {
      for (const char* channel : {".R", ".G", ".B"}) names.push_back(begin + layer + channel);
    }
  };
  add("");
  if (!aovs.contains(Aov::kDenoising)) return names;
  for (const char* half : kHalfNames) add(std::string(half) + ".");
  return names;
}

float* put_light_layers(const FilmTile& tile, size_t i, float* values) {
  for (int group = 0; group < tile.extras().light_groups; ++group) {
    const Rgb mean = tile.lights(i).mean(group);
    values = std::copy_n(&mean.x, 3, values);
  }
  const int halves = tile.has(Sums::kHalves) ? 2 : 0;
  for (int half = 0; half < halves; ++half) values = put_half_lights(tile, i, half, values);
  return values;
}

std::string describe(const LightGroups& groups) {
  auto names = groups.list() | std::views::transform(&LightGroup::name);
  return fmt::format("light groups ({}: {})", groups.size(), fmt::join(names, ", "));
}

}  // namespace emberline
