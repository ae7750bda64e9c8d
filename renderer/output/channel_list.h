// The table of channels (renderer/film/channels.h) for people and for programs.
#pragma once

#include <string>

namespace emberline {

// As JSON a list of {"name", "channels", "setting", "value", "unit", "whole_numbers", "half",
// "lossy", "denoised", "summary"}, in the order in which pictures have them; no channels where the
// scene names them.
std::string channel_list(bool as_json);

}  // namespace emberline
