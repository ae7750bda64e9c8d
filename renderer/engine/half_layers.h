// `--half`: layers whose channels are stored as half floats.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace emberline {

struct HalfLayer {
  std::string_view name;  // as in --half
  std::string_view summary;
};
// The layers that --half accepts, as listed in its --help and its error message.
std::span<const HalfLayer> half_layer_table();

// Splits a list such as "N,albedo". Throws a UsageError that lists the valid names if a name is
// unknown.
std::vector<std::string> parse_half_layers(std::string_view list);
// Returns whether the channel belongs to one of these layers. Some names, such as "light", stand
// for several of the file's layers.
bool is_half(std::string_view channel, const std::vector<std::string>& layers);

}  // namespace emberline
