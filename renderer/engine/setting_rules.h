// Which settings go together: a table of rules, the function that checks them, and their help
// texts. Names of drivers, integrators, samplers and estimators come from their own tables.
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

// A condition on one setting: that it is given, or that it has a value.
struct SettingIs {
  std::string_view name;
  std::string_view value = {};    // of a list: among others; empty: any that is not the default
  std::string_view except = {};   // any other than this
  std::string_view with = {};     // and this setting is given
  std::string_view without = {};  // and this setting is not given
};
using AnySetting = std::vector<SettingIs>;  // at least one of them holds

// Applies where one of `about` holds and none of `unless`. Then one of `needs` must hold, and none
// of `excludes`.
struct SettingRule {
  AnySetting about;
  AnySetting needs = {};
  AnySetting excludes = {};
  AnySetting unless = {};
  // Why, for messages. "{}" is the value that the first setting of `needs` has.
  std::string reason = {};
  // For rules that compare numbers, in place of `needs` and `excludes`: returns what is wrong, with
  // the names of the settings, or an empty text.
  std::function<std::string(const FrameSettings&)> wrong = {};
  bool in_help = true;  // false: the setting's help already says it
};

// The rules for the settings of every frame. Clients that have further options add tables.
std::span<const SettingRule> setting_rules();

// Whether a condition holds. A client with further options has a function that knows them, too.
using SettingHolds = std::function<bool(const SettingIs&)>;
bool setting_holds(const FrameSettings& settings, const SettingIs& is);

// Returns what is wrong in one line; empty if the settings obey the rule.
std::string broken_rule(const SettingRule& rule, const FrameSettings& settings,
                        const SettingHolds& holds);
// Throws UsageError for the first rule that is broken: the setting, what it needs or excludes, the
// reason.
void check_rules(std::span<const SettingRule> rules, const FrameSettings& settings,
                 const SettingHolds& holds);
void check_rules(const FrameSettings& settings);
// Only the rules about this setting.
void check_rules(const FrameSettings& settings, std::string_view about);

// Whether the rules allow this setting, which need not be given, beside the others.
bool setting_is_allowed(const FrameSettings& settings, std::string_view name);

// The drivers that fit, from their table.
AnySetting drivers_that(const std::function<bool(const DriverEntry&)>& fits);

// Describes the rules about a setting, or one of its values: "; requires `env` or `sun`". Empty if
// there are none.
std::string rules_of(std::span<const SettingRule> rules, std::string_view name,
                     std::string_view value = {});

// Texts that follow a setting's help: its rules, and a line for each valid name with its rules.
struct RulesHelp {
  std::string rules, values;
};
const RulesHelp& rules_of(const Setting& setting);

}  // namespace emberline
