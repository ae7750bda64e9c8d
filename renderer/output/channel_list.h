// Lists the table of channels (renderer/film/channels.h) as text or JSON.
#pragma once

#include <string>

namespace emberline {

// The JSON is a list of {"name", "channels", "setting", "value", "unit", "whole_numbers", "half",
// "lossy", "denoised", "summary"} in picture order. "channels" is empty if the scene determines the
// names.
std::string channel_list(bool as_json);

}  // namespace emberline
