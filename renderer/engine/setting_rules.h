// Rules for combining settings, with checks and help texts. Names of drivers, integrators, samplers
// and estimators come from their own tables.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/drivers/driver_table.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/engine/setting_table.h"

namespace emberline {

// The condition that a setting is given or has a certain value.
struct SettingCondition {
  std::string_view name;
  std::string_view value = {};    // value or list entry; empty: any non-default value
  std::string_view with = {};     // this setting must be given as well
  std::string_view without = {};  // this setting must not be given
};
using AnyCondition = std::vector<SettingCondition>;  // holds if one of its conditions holds

// A rule applies if at least one condition in `about` and none in `unless` holds. Then at least one
// in `needs` (unless it is empty) and none in `excludes` must hold.
struct SettingRule {
  AnyCondition about;
  AnyCondition needs = {};
  AnyCondition excludes = {};
  AnyCondition unless = {};
  // The reason, for messages. "{}" stands for the value of the first setting in `needs`.
  std::string reason = {};
  // For rules that compare numbers, instead of `needs` and `excludes`: returns an error with the
  // settings' names, or an empty text.
  std::function<std::string(const FrameSettings&)> violation = {};
  bool in_help = true;  // false: the setting's help already states the rule
};

// The rules for frame settings. Clients that have further options add their own tables.
std::span<const SettingRule> setting_rules();

// Evaluates a condition. Clients that have further options pass their own function.
using SettingHolds = std::function<bool(const SettingCondition&)>;
bool setting_holds(const FrameSettings& settings, const SettingCondition& condition);

// Returns a one-line error, or an empty text if the settings obey the rule.
std::string find_violation(const SettingRule& rule, const FrameSettings& settings,
                           const SettingHolds& holds);
// Throws UsageError for the first broken rule. The message names the setting, what the setting
// requires or excludes, and why.
void check_rules(std::span<const SettingRule> rules, const FrameSettings& settings,
                 const SettingHolds& holds);
void check_rules(const FrameSettings& settings);
// Checks only the rules about this setting.
void check_rules(const FrameSettings& settings, std::string_view about);

// Returns whether the rules allow this setting together with the other given settings. This setting
// itself need not be given.
bool setting_is_allowed(const FrameSettings& settings, std::string_view name);

// Returns one condition for each driver for which `fits` is true.
AnyCondition find_drivers(const std::function<bool(const DriverEntry&)>& fits);

// Describes the rules about a setting or one of its values, for example "; requires `env` or
// `sun`". The text is empty if there are no rules.
std::string rules_of(std::span<const SettingRule> rules, std::string_view name,
                     std::string_view value = {});

// The texts to append to a setting's help: the setting's rules, and for each valid name a line with
// the name's rules.
struct RulesHelp {
  std::string rules, values;
};
const RulesHelp& rules_of(const Setting& setting);

// Turns the text of rules_of() into sentences, such as " Requires `env` or `sun`. Cannot be
// combined with `time`."
std::string as_sentences(std::string_view rules);

}  // namespace emberline
