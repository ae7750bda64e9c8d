// Spelling of setting names in messages and help texts. The sources write a name in backticks, such
// as `noise-threshold`. Each program spells the name as its users do: --noise-threshold in the
// command, noise_threshold in Python.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// Returns the text that replaces a name and its backticks. If the name is not a setting, returns an
// empty string, and the name and its backticks stay.
using SettingFormatter = std::string (*)(std::string_view name);

// Sets the formatter for the whole process; call it before the first message. By default, names
// appear without the backticks.
void spell_settings(SettingFormatter formatter);

std::string spell_setting_names(std::string_view text);

}  // namespace emberline
