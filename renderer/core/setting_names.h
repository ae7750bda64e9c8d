// Spelling of setting names in messages and help texts. The sources write a name in backticks, as
// `noise-threshold`; each program spells it as its users do: --noise-threshold in the command,
// noise_threshold in Python.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// Returns the replacement for the backticks and the name, or an empty string to keep both if this
// is not a setting.
using SettingFormatter = std::string (*)(std::string_view name);

// Process-wide; call it before the first message. The default is the bare name.
void spell_settings(SettingFormatter formatter);

std::string spell_setting_names(std::string_view text);

}  // namespace emberline
