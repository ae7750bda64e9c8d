// Formats the table of channels (renderer/film/channels.h) as text or as JSON.
#pragma once

#include <string>

namespace emberline {

// The JSON is a list of {"name", "channels", "setting", "value", "unit", "whole_numbers", "half",
// "lossy", "denoised", "summary"}. It has the order in which pictures contain the channels.
// "channels" is empty if the names of the channels depend on the scene.
std::string channel_list(bool as_json);

}  // namespace emberline
