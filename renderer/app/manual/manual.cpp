#include "renderer/app/manual/command_help.h"

#include <algorithm>
#include <cctype>
#include <iterator>

#include "renderer/core/version.h"

namespace emberline {
namespace {

// The characters that roff would typeset differently, and their escapes; see groff_char(7).
constexpr std::pair<char, const char*> kEscapes[] = {
    {'\\', "\\e"}, {'-', "\\-"}, {'\'', "\\(aq"}, {'`', "\\(ga"}, {'^', "\\(ha"}, {'~', "\\(ti"}};

std::string escape_roff(const std::string& text) {
  // A leading '.' or '\'' would begin a request.
  std::string out = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) {
    const auto* const found = std::ranges::find(kEscapes, c, &std::pair<char, const char*>::first);
    out += found == std::end(kEscapes) ? std::string(1, c) : found->second;
  }
  return out;
}

std::string bold(const std::string& text) { return "\\fB" + escape_roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escape_roff(text) + "\\fR"; }

std::string hyphenated(std::string name) {
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string synopsis(const CommandHelp& command) {
  std::string text = bold(command.name) + " [" + italic("OPTION") + "]...";
  for (const OptionHelp& option : command.options) {
    if (!option.argument) continue;
    const std::string name =
        italic(upper_case(option.names.front())) + (option.repeats ? "..." : "");
    text += option.required ? " " + name : " [" + name + "]";
  }
  return text + "\n";
}

std::string option_entry(const OptionHelp& option) {
  std::string text = ".TP\n";
  for (const std::string& name : option.names) {
    if (&name != &option.names.front()) text += ", ";
    text += option.argument ? italic(upper_case(name)) : bold(name);
  }
  if (!option.argument && !option.type.empty()) text += " " + italic(option.type);
  text += "\n" + escape_roff(option.text);
  if (!option.fallback.empty()) text += " Default: " + escape_roff(option.fallback) + ".";
  text += "\n";
  if (!option.example.empty()) text += ".br\nExample: " + italic(option.example) + "\n";
  if (option.values.empty() || option.values.front().second.empty()) return text;
  text += ".RS\n";
  for (const auto& [name, meaning] : option.values) {
    text += ".TP\n" + bold(name) + "\n" + escape_roff(meaning) + "\n";
  }
  return text + ".RE\n";
}

// Lists arguments first, then the options by section.
std::string option_entries(const CommandHelp& command) {
  std::string text;
  for (const OptionHelp& option : command.options) {
    if (option.argument) text += option_entry(option);
  }
  for (const std::string& title : sections_of(command.options)) {
    text += ".SS " + escape_roff(title) + "\n";
    for (const OptionHelp& option : command.options) {
      if (!option.argument && option.section == title) text += option_entry(option);
    }
  }
  return text;
}

std::string examples_section(const CommandHelp& command) {
  if (command.examples.empty()) return "";
  std::string text = ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : command.examples) text += escape_roff(example) + "\n";
  return text + ".fi\n";
}

// Only the root's page has this section.
std::string commands_section(const CommandHelp& root) {
  std::string text = ".SH COMMANDS\nEach command has its own page.\n";
  for (const CommandHelp& command : root.commands) {
    text +=
        ".TP\n" + bold(hyphenated(command.name)) + "(1)\n" + escape_roff(command.summary) + "\n";
  }
  return text;
}

std::string subcommand_section(const CommandHelp& command) {
  return ".SH " + escape_roff(upper_case(command.name)) + "\n" + escape_roff(command.summary) +
         "\n.PP\n" + synopsis(command) + option_entries(command);
}

// Converts "Render a scene." to "render a scene" for the NAME section, which whatis(1) prints.
std::string to_phrase(std::string text) {
  if (text.ends_with('.')) text.pop_back();
  if (!text.empty()) text[0] = char(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

std::string title(const CommandHelp& command) {
  const std::string name = hyphenated(command.name);
  return ".\\\" Written by emberline from its own options.\n.TH " + escape_roff(upper_case(name)) +
         " 1 \"\" \"Emberline " + kEmberlineVersion + "\" Emberline\n.SH NAME\n" +
         escape_roff(name) + " \\- " + escape_roff(to_phrase(command.summary)) + "\n.SH SYNOPSIS\n";
}

constexpr std::pair<int, const char*> kExitCodes[] = {
    {0, "done; also if a time limit ended the frame"},
    {1, "the render or a write failed; with --strict, also if a time limit left pixels black"},
    {2, "the command line is wrong"},
    {3, "an input file cannot be used"},
    {130,
     "stopped by the user or a signal, or with --resume by a time limit; the unfinished picture is "
     "written"}};

std::string exit_status() {
  std::string text = ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : kExitCodes) {
    text += ".TP\n.B " + std::to_string(code) + "\n" + meaning + "\n";
  }
  return text;
}

}  // namespace

std::string manual_name(const CommandHelp& command) { return hyphenated(command.name) + ".1"; }

std::string manual_page(const CommandHelp& command) {
  const bool is_root = command.is_root();
  std::string text = title(command);
  if (is_root) text += bold(command.name) + " " + italic("COMMAND") + " ...\n.br\n";
  text += synopsis(command);
  if (is_root) text += commands_section(command);
  text += ".SH OPTIONS\n" + option_entries(command);
  if (!is_root) {
    for (const CommandHelp& subcommand : command.commands) text += subcommand_section(subcommand);
  }
  text += examples_section(command) + exit_status();
  return is_root ? text : text + ".SH SEE ALSO\n" + bold("emberline") + "(1)\n";
}

}  // namespace emberline
