// `--half`: layers whose channels are stored in half floats.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

struct HalfLayer {
  std::string_view name;  // what --half calls it
  std::string_view summary;
};
// The table behind --half, its --help and its error message.
std::span<const HalfLayer> half_layer_table();

// "N,albedo" -> those names. Throws UsageError that lists the valid ones.
std::vector<std::string> parse_half_layers(std::string_view list);
// Whether the channel belongs to one of these layers; "light" and others name several layers.
bool is_half(std::string_view channel, const std::vector<std::string>& layers);

}  // namespace emberline
