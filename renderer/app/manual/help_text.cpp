// The texts of --help, --help-all and `emberline help`.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "renderer/app/manual/command_help.h"
#include "renderer/app/usage_error.h"
#include "renderer/engine/setting_table.h"

namespace emberline {
namespace {

constexpr size_t kHelpWidth = 100;   // columns
constexpr size_t kBriefColumn = 30;  // where the short texts begin
constexpr size_t kMaxBriefLength = 70;

// Breaks `text` into lines. The first line begins with `first`, the other lines with `indent`
// spaces.
std::string wrap_text(const std::string& text, const std::string& first, size_t indent) {
  std::string out, line = first;
  bool empty = true;  // whether the line has only its indentation
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    if (!empty && line.size() + 1 + (end - begin) > kHelpWidth) {
      out += line + "\n";
      line = std::string(indent, ' ');
      empty = true;
    }
    line += (empty ? "" : " ") + text.substr(begin, end - begin);
    empty = false;
    begin = end + 1;
  }
  return out + line + "\n";
}

// Returns the option's line in --help. Shortens its type, for example to N for a range of numbers.
std::string brief_line(const OptionHelp& option) {
  OptionHelp shortened = option;
  if (option.type.find("..") != std::string::npos) shortened.type = "N";
  std::string& type = shortened.type;
  constexpr size_t kMaxWidth = kBriefColumn - 4;  // two spaces on each side
  while (option_line(shortened).size() > kMaxWidth && type.find('|') != std::string::npos) {
    type.resize(type.rfind('|'));
  }
  return option_line(shortened);
}

std::string brief_text(const OptionHelp& option) {
  const std::string with_default = option.brief + " [" + option.fallback + "]";
  const bool fits = !option.fallback.empty() && !option.brief.ends_with(']') &&
                    with_default.size() <= kMaxBriefLength;
  return fits ? with_default : option.brief;
}

std::string command_list(const CommandHelp& command) {
  std::string text = "\nCommands:\n";
  for (const CommandHelp& each : command.commands) {
    const std::string name = each.name.substr(command.name.size() + 1);
    text += fmt::format("  {:<10}{}\n", name, each.summary);
  }
  return text;
}

// Returns the lines below an option's text: the valid names, the default and an example.
std::string option_details(const OptionHelp& option, size_t indent) {
  std::string text;
  const std::string spaces(indent, ' ');
  if (!option.values.empty() && !option.values.front().second.empty()) {
    for (const auto& [name, meaning] : option.values) {
      text += wrap_text(meaning, fmt::format("{}  {}: ", spaces, name), indent + 6);
    }
  }
  if (!option.fallback.empty()) text += wrap_text(option.fallback, spaces + "Default: ", indent);
  if (!option.example.empty()) text += spaces + "Example: " + option.example + "\n";
  return text;
}

std::string full_entry(const OptionHelp& option) {
  return "  " + option_line(option) + "\n" + wrap_text(option.text, std::string(6, ' '), 6) +
         option_details(option, 6);
}

std::string_view without_dashes(std::string_view name) {
  return name.substr(std::min(name.find_first_not_of('-'), name.size()));
}

}  // namespace

std::string option_line(const OptionHelp& option) {
  const std::string names = fmt::format("{}", fmt::join(option.names, ", "));
  if (option.argument) return upper_case(names) + (option.repeats ? "..." : "");
  return option.type.empty() ? names : names + " " + option.type;
}

std::string usage_line(const CommandHelp& command) {
  std::string text = command.name;
  if (command.is_root()) return text + " COMMAND [OPTION]...";
  for (const OptionHelp& option : command.options) {
    if (!option.argument && !option.required) continue;
    const std::string line =
        option.argument ? option_line(option) : option.names.front() + " " + option.type;
    text += option.required ? " " + line : " [" + line + "]";
  }
  return text + " [OPTION]...";
}

std::vector<std::string> sections_of(const std::vector<OptionHelp>& options) {
  std::vector<std::string> titles;
  for (size_t i = 0; i <= size_t(HelpSection::kGeneral); ++i) {
    const std::string title(title_of(HelpSection(i)));
    const bool used = std::ranges::any_of(options, [&](const OptionHelp& option) {
      return !option.argument && option.section == title;
    });
    if (used) titles.push_back(title);
  }
  return titles;
}

std::string brief_help(const CommandHelp& command) {
  std::vector<OptionHelp> common;
  std::ranges::copy_if(command.options, std::back_inserter(common),
                       [](const OptionHelp& option) { return !option.brief.empty(); });
  std::string text = command.summary + "\nUsage: " + usage_line(command) + "\n";
  if (!command.commands.empty()) text += command_list(command);
  text += "\n";
  for (const std::string& title : sections_of(common)) {
    text += title + ":\n";
    for (const OptionHelp& option : common) {
      if (option.section != title) continue;
      text += fmt::format("  {:<{}}{}\n", brief_line(option), kBriefColumn - 2, brief_text(option));
    }
  }
  if (!command.examples.empty()) text += "\nExamples:\n";
  for (const std::string& example : command.examples) text += "  " + example + "\n";
  if (command.is_root()) return text + "\nA command's options: emberline help COMMAND\n";
  return text + fmt::format("\nAll options: {} --help-all. One option: emberline help {} OPTION\n",
                            command.name, command.name.substr(command.name.find(' ') + 1));
}

std::string full_help(const CommandHelp& command) {
  std::string text = command.summary + "\nUsage: " + usage_line(command) + "\n";
  if (!command.commands.empty()) text += command_list(command);
  bool first = true;
  for (const OptionHelp& option : command.options) {
    if (!option.argument) continue;
    if (first) text += "\nArguments:\n";
    first = false;
    text += full_entry(option);
  }
  for (const std::string& title : sections_of(command.options)) {
    text += "\n" + title + ":\n";
    for (const OptionHelp& option : command.options) {
      if (!option.argument && option.section == title) text += full_entry(option);
    }
  }
  if (!command.examples.empty()) text += "\nExamples:\n";
  for (const std::string& example : command.examples) text += "  " + example + "\n";
  return text;
}

std::string option_page(const CommandHelp& command, const std::string& name) {
  std::vector<std::string> all;
  for (const OptionHelp& option : command.options) {
    for (const std::string& each : option.names) {
      if (without_dashes(each) == without_dashes(name)) {
        return option_line(option) + "\n" + wrap_text(option.text, "  ", 2) +
               option_details(option, 2);
      }
      if (!option.argument) all.push_back(each);
    }
  }
  throw_unknown_option("--" + std::string(without_dashes(name)), all, command.name);
}

}  // namespace emberline
