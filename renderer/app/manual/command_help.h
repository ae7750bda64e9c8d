// The help of commands and options as plain data, for --help, man pages, completion and the manual.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace emberline {

struct OptionHelp {
  std::vector<std::string> names;  // "-o", "--output"; a positional one has no dashes
  bool argument = false;           // positional
  std::string section;             // title_of() a HelpSection
  std::string type;                // of its value; empty for a flag
  std::string brief;               // one line for --help; empty: not in --help
  std::string text;                // a paragraph
  std::vector<std::pair<std::string, std::string>> values;  // valid names and their meanings
  std::string fallback;                                     // the default; empty: none
  std::string example;                                      // options as typed; empty: none
  std::vector<std::string> suffixes;  // of the files that it names, taken from `text`
  bool required = false, repeats = false;
};

struct CommandHelp {
  std::string name;  // "emberline render"
  std::string summary;
  std::vector<std::string> examples;  // command lines
  std::vector<OptionHelp> options;
  std::vector<CommandHelp> commands;
  bool is_root() const { return name.find(' ') == std::string::npos; }
};

// Returns the help of a command, given the names of the commands above it, such as "emberline ".
CommandHelp command_help(const CLI::App& app, const std::string& parent_names = "");

std::string upper_case(std::string text);

// "emberline render SCENE -o FILE [OPTION]..."
std::string usage_line(const CommandHelp& command);
// Titles of sections in their order, without those that have none of `options`.
std::vector<std::string> sections_of(const std::vector<OptionHelp>& options);
// "-o, --output FILE"
std::string option_line(const OptionHelp& option);

// --help: the common options, one line each, and examples.
std::string brief_help(const CommandHelp& command);
// --help-all: all options with their values.
std::string full_help(const CommandHelp& command);
// `emberline help COMMAND OPTION`; `name` is the option with or without dashes. Throws UsageError.
std::string option_page(const CommandHelp& command, const std::string& name);

// Markdown pages of the manual: the options of all commands, and the table of channels.
std::string options_page(const CommandHelp& root);
std::string channels_page();

// A man(7) page of one command. Each subcommand of the root has a page of its own, and deeper ones
// have a section of their parent's page.
std::string manual_page(const CommandHelp& command);
// "emberline-render.1"
std::string manual_name(const CommandHelp& command);

// A script for bash 4 that completes commands, options, values, and files by suffix.
std::string bash_completion(const CommandHelp& root);
// For a folder of $fpath, as _emberline.
std::string zsh_completion(const CommandHelp& root);

}  // namespace emberline
