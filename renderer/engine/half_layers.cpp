#include "renderer/engine/half_layers.h"

#include <algorithm>

#include "io/exr/writer.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"

namespace emberline {
namespace {

// Not what is counted, an id, or what `denoise` reads.
constexpr HalfLayer kLayers[] = {
    {"RGBA", "the picture"},
    {"albedo", "of `aov`, as the next seven"},
    {"N", "normals"},
    {"Z", "depth; at most 65504"},
    {"P", "positions: eleven bits of each coordinate"},
    {"UV", "texture coordinates"},
    {"velocity", "motion"},
    {"variance", "what it can hold of the variance"},
    {"clamped", "what was clamped"},
    {"direct", "layers by light path, as the next five"},
    {"indirect", "as in `aov`"},
    {"emission", "as in `aov`"},
    {"transmission", "as in `aov`"},
    {"reflection", "as in `aov`"},
    {"environment", "as in `aov`"},
    {"shadow", "of `catcher`"},
    {"light", "all of `light-groups`"},
    {"denoised", "the clean picture of `denoise`, and its error"},
};

}  // namespace

std::span<const HalfLayer> half_layer_table() { return kLayers; }

std::vector<std::string> parse_half_layers(std::string_view list) {
  std::vector<std::string> layers;
  for (const std::string_view name : split_list(list)) {
    layers.emplace_back(find_named(kLayers, "`half`", "layer", name).name);
  }
  return layers;
}

bool is_half(std::string_view channel, const std::vector<std::string>& layers) {
  const std::string of = layer_of(std::string(channel));
  return std::ranges::any_of(
      layers, [&](const std::string& layer) { return of == layer || of.starts_with(layer + "."); });
}

}  // namespace emberline
