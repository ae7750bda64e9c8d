// Generates the manual's pages about options and channels from the tables of options and channels.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "renderer/app/manual/command_help.h"
#include "renderer/output/channel_list.h"

namespace emberline {
namespace {

// Escapes the text so that Markdown shows it unchanged, even within a table.
std::string escape_markdown(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
      continue;
    }
    if (std::string_view("\\*_#[]|").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string as_code(const std::string& text) { return "`" + text + "`"; }

std::string option_paragraph(const OptionHelp& option) {
  std::string text = "**" + as_code(option_line(option)) + "**  \n" + escape_markdown(option.text);
  if (!option.fallback.empty()) text += " Default: " + escape_markdown(option.fallback) + ".";
  text += "\n\n";
  if (!option.values.empty() && !option.values.front().second.empty()) {
    for (const auto& [name, meaning] : option.values) {
      text += "- " + as_code(name) + ": " + escape_markdown(meaning) + "\n";
    }
    text += "\n";
  }
  if (!option.example.empty()) text += "Example: " + as_code(option.example) + "\n\n";
  return text;
}

std::string command_section(const CommandHelp& command, int level) {
  std::string text =
      fmt::format("{} {}\n\n{}\n\n```\n{}\n", std::string(size_t(level), '#'), command.name,
                  escape_markdown(command.summary), usage_line(command));
  for (const std::string& example : command.examples) text += example + "\n";
  text += "```\n\n";
  for (const OptionHelp& option : command.options) {
    if (option.argument) text += option_paragraph(option);
  }
  for (const std::string& title : sections_of(command.options)) {
    text += fmt::format("{} {}\n\n", std::string(size_t(level) + 1, '#'), title);
    for (const OptionHelp& option : command.options) {
      if (!option.argument && option.section == title) text += option_paragraph(option);
    }
  }
  for (const CommandHelp& subcommand : command.commands)
    text += command_section(subcommand, level + 1);
  return text;
}

}  // namespace

std::string options_page(const CommandHelp& root) {
  std::string text =
      "# Options\n\nAll options of all commands. `emberline help COMMAND OPTION` shows the same "
      "text "
      "for one option.\n\n";
  for (const CommandHelp& command : root.commands) text += command_section(command, 2);
  return text;
}

std::string channels_page() {
  std::string text =
      "# Channels\n\nThe channels that an EXR can have. `emberline info --channels` prints the "
      "same "
      "table.\n\n| channel | option | value | unit | meaning |\n| --- | --- | --- | --- | --- |\n";
  for (const auto& row : nlohmann::ordered_json::parse(channel_list(true))) {
    const std::string name = row["name"], setting = row["setting"], summary = row["summary"];
    const std::string option = setting == "aov" ? "--aov " + name : "--" + setting;
    text += fmt::format("| {} | {} | {} | {} | {} |\n", as_code(name),
                        setting.empty() ? "" : as_code(option), row["value"].get<std::string>(),
                        escape_markdown(row["unit"].get<std::string>()), escape_markdown(summary));
  }
  return text;
}

}  // namespace emberline
