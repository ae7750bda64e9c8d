#include "renderer/output/light_layers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <set>

#include "renderer/film/film.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/light_group_sums.h"
#include "renderer/output/appended_channels.h"

namespace emberline {
namespace {

// EXR holds names of 255 bytes, of which the channel takes two and a number some.
constexpr size_t kLongestName = 200;

std::string safe_name(const std::string& name) {
  std::string safe = name.substr(0, kLongestName);
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
  std::set<std::string> taken;
  for (size_t i = 0; i < groups.size(); ++i) {
    const std::string base = "light." + safe_name(groups[i].name);
    std::string name = groups[i].name.empty() ? fmt::format("{}{}", base, i) : base;
    for (int number = 2; !taken.insert(name).second; ++number) {
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

void append_light_layers(const FilmTile& tile, std::vector<float>& pixels) {
  const auto count = size_t(tile.rect().area());
  const auto groups = size_t(tile.extras().light_groups);
  const int halves = tile.has(Sums::kHalves) ? 2 : 0;
  append_channels(count, 3 * groups * size_t(1 + halves), pixels, [&](size_t i, float* values) {
    for (size_t g = 0; g < groups; ++g) {
      const Rgb mean = tile.lights(i).mean(int(g));
      values = std::copy_n(&mean.x, 3, values);
    }
    for (int half = 0; half < halves; ++half) values = put_half_lights(tile, i, half, values);
  });
}

std::string describe(const LightGroups& groups) {
  auto names = groups.list() | std::views::transform(&LightGroup::name);
  return fmt::format("light groups ({}: {})", groups.size(), fmt::join(names, ", "));
}

}  // namespace emberline
