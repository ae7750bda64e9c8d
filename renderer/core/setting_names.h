// How messages and help texts name settings. In the sources a setting's name stands between
// backticks, as `noise-threshold`; the program that runs spells it as its users write it: the
// command --noise-threshold, Python noise_threshold.
#pragma once

#include <string>
#include <string_view>

namespace emberline {

// What stands in place of the backticks and the name; empty: this is no setting, and all stays.
using SpellSetting = std::string (*)(std::string_view name);

// For the whole process, before its first message. As long as nobody has: the bare name.
void spell_settings(SpellSetting spell);

std::string spelled(std::string_view text);

}  // namespace emberline
