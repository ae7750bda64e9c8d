// Options that several subcommands share, and how their values are parsed.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/render_options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace emberline {

// Returns the "name: summary" lines of a table. These lines follow the full help of an option.
template <typename Table>
std::string table_lines(const Table& table) {
  std::string text;
  for (const auto& entry : table) text += fmt::format("\n  {}: {}", entry.name, entry.summary);
  return text;
}

// Stores the help in the option; manual/command_help.cpp reads it from there.
CLI::Option* describe(CLI::Option* option, const OptionText& text, const std::string& lines = "");

// Appends rules to the option's full help, one sentence for each rule. `rules` is a text from
// rules_of().
void add_rules(CLI::Option* option, std::string_view rules);

// Adds an option. `read` parses the value, and returns false if it is invalid. `what` describes
// valid values, such as "a number above 0".
CLI::Option* add_parsed(CLI::App* app, const std::string& name, const std::string& type,
                        const OptionText& text, const std::string& what,
                        const std::function<bool(const std::string& text)>& read);

// Adds an option whose value is a number in [min, max]. `Target` is T or std::optional<T>.
template <typename T, typename Target>
CLI::Option* add_number(CLI::App* app, const std::string& name, Target& target, T min, T max,
                        const OptionText& help) {
  const auto read = [&target, min, max](const std::string& text) {
    const std::optional<T> value = parse_number<T>(text);
    if (!value || *value < min || *value > max) return false;
    target = *value;
    return true;
  };
  const char* kind = std::is_integral_v<T> ? "whole number" : "number";
  return add_parsed(app, name, fmt::format("{}..{}", min, max), help,
                    fmt::format("a {} from {} to {}", kind, min, max), read);
}

// Adds an option whose value is a text, such as a file name. If `target` is a vector, the option
// may be repeated and adds one value each time.
CLI::Option* add_text(CLI::App* app, const std::string& option, std::string& target,
                      const std::string& type, const OptionText& help);
CLI::Option* add_text(CLI::App* app, const std::string& option, std::optional<std::string>& target,
                      const std::string& type, const OptionText& help);
CLI::Option* add_text(CLI::App* app, const std::string& option, std::vector<std::string>& target,
                      const std::string& type, const OptionText& help);

// Adds a positional argument, such as the scene.
CLI::Option* add_argument(CLI::App* app, const std::string& name, std::string& target,
                          const std::string& help);

CLI::Option* add_flag(CLI::App* app, const std::string& option, bool& target,
                      const OptionText& help);

// Adds an option whose value is a name. `check` throws UsageError for an unknown name. `lines`
// lists the valid names for the help.
CLI::Option* add_checked_name(CLI::App* app, const std::string& option, std::string& target,
                              const std::function<void(const std::string& name)>& check,
                              const OptionText& help, const std::string& lines);

// Adds an option whose value is a name from `table`, checked while the command line is parsed.
template <typename Table>
CLI::Option* add_name(CLI::App* app, const std::string& option, std::string& target,
                      const char* kind, const OptionText& help, const Table& table) {
  const auto check = [=](const std::string& name) { find_named(table, option, kind, name); };
  return add_checked_name(app, option, target, check, help, table_lines(table));
}

// Adds an option whose value is a size in bytes with an optional unit; see parse_size().
void add_size(CLI::App* app, const std::string& option, std::optional<uint64_t>& bytes,
              const OptionText& help);

// Adds the settings of these groups, except the settings in `excluded`, which have another meaning
// in this command.
void add_settings(CLI::App* app, FrameSettings& settings,
                  std::initializer_list<SettingGroup> groups,
                  std::initializer_list<std::string_view> excluded = {});
void add_setting(CLI::App* app, const Setting& setting, FrameSettings& settings);
// Adds --settings. The file is read before all other settings, which override it.
void add_settings_file(CLI::App* app, RenderOptions& options);

void add_limits(CLI::App* app, LimitOptions& options);
void add_checkpoint_interval(CLI::App* app, RenderOptions& options);
void add_threads(CLI::App* app, int& threads);
// Calls add_threads() and add_limits().
void add_machine_options(CLI::App* app, RenderOptions& options);

// Adds options for a heatmap's style. Each of them requires `required_option`, unless this is null.
void add_heatmap_style(CLI::App* app, HeatmapStyle& style, CLI::Option* required_option);
void add_heatmaps(CLI::App* app, RenderOptions& options);
void add_grading(CLI::App* app, DisplaySettings& options);
// Calls add_grading() and adds --display.
void add_display_options(CLI::App* app, DisplaySettings& options);
// Adds options for the pictures and the report of a command other than `render`.
void add_outputs(CLI::App* app, RenderOptions& options, const OptionText& output,
                 const OptionText& report);

// The largest value of --across, and what the option does.
inline constexpr int kMaxAcross = 4;
inline constexpr const char* kAcrossText =
    "Combine each frame with up to N frames before and N frames after it, moved by their velocity, "
    "where they show the same surface in the same light. Motion by more than 64 rows is not "
    "followed. A frame without enough neighbours is filtered with those that exist.";

}  // namespace emberline
