// The help of commands and options as plain data, for man pages and completion.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace emberline {

struct OptionHelp {
  std::vector<std::string> names;  // "-o", "--output"; a positional one has no dashes
  bool argument = false;           // positional
  std::string type;                // of its value; empty for a flag
  std::string text;                // a paragraph
  std::vector<std::pair<std::string, std::string>> values;  // valid names and their meanings
  std::vector<std::string> suffixes;  // of the files that it names, taken from `text`
  bool required = false, repeats = false;
};

struct CommandHelp {
  std::string name;  // "emberline render"
  std::string summary;
  std::vector<OptionHelp> options;
  std::vector<CommandHelp> commands;
};

CommandHelp command_help(const CLI::App& root);

// A man(7) page of one command. Each subcommand of the root has a page of its own, and deeper ones
// have a section of their parent's page.
std::string manual_page(const CommandHelp& command);
// "emberline-render.1"
std::string manual_name(const CommandHelp& command);

// What a shell completes after `emberline`: commands, options, values, and files by suffix. To be
// sourced; needs bash 4 and no other file.
std::string bash_completion(const CommandHelp& root);
// For a folder of $fpath, as _emberline.
std::string zsh_completion(const CommandHelp& root);

}  // namespace emberline
