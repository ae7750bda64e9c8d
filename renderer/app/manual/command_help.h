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
  std::vector<std::string> names;  // "-o", "--output"; no dashes if positional
  bool argument = false;           // positional
  std::string section;             // title_of() a HelpSection
  std::string type;                // type of the value; empty for a flag
  std::string brief;               // one line for --help; empty: --help does not list the option
  std::string text;                // a paragraph
  std::vector<std::pair<std::string, std::string>> values;  // valid names and their meanings
  std::string fallback;                                     // the default; empty: none
  std::string example;                                      // the option as typed; empty: none
  std::vector<std::string> suffixes;                        // file suffixes that occur in `text`
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

// Returns the help of a command. `parent_names` are the commands above it, such as "emberline ".
CommandHelp command_help(const CLI::App& app, const std::string& parent_names = "");

std::string upper_case(std::string text);

// Returns "emberline render SCENE -o FILE [OPTION]...".
std::string usage_line(const CommandHelp& command);
// Returns the titles of the sections to which `options` belong, in the order of HelpSection.
std::vector<std::string> sections_of(const std::vector<OptionHelp>& options);
// Returns "-o, --output FILE".
std::string option_line(const OptionHelp& option);

// Returns the text of --help: one line for each common option, and examples.
std::string brief_help(const CommandHelp& command);
// Returns the text of --help-all: all options with their values.
std::string full_help(const CommandHelp& command);
// Returns the text of `emberline help COMMAND OPTION`; `name` is the option with or without dashes.
// Throws UsageError.
std::string option_page(const CommandHelp& command, const std::string& name);

// Return Markdown pages of the manual: the options of all commands, and the table of channels.
std::string options_page(const CommandHelp& root);
std::string channels_page();

// Returns the man page of a command, in the format of man(7). Each command of the root has its own
// page, which describes the command's subcommands in sections.
std::string manual_page(const CommandHelp& command);
// Returns "emberline-render.1".
std::string manual_name(const CommandHelp& command);

// Returns a script for bash 4 that completes commands, options, values, and files by suffix.
std::string bash_completion(const CommandHelp& root);
// Returns a script for zsh, to be saved as _emberline in a folder of $fpath.
std::string zsh_completion(const CommandHelp& root);

}  // namespace emberline
