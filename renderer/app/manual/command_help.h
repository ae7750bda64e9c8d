// What the commands and their options say of themselves, as plain data: for man pages and
// completion.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace emberline {

struct OptionHelp {
  std::vector<std::string> names;  // "-o", "--output"; an argument has one, without dashes
  bool argument = false;           // given by its place
  std::string type;                // of its value; empty: it has none
  std::string text;                // a paragraph
  std::vector<std::pair<std::string, std::string>> values;  // valid names, and what they mean
  std::vector<std::string> suffixes;  // of the files that it names: those of which `text` speaks
  bool required = false, repeats = false;
};

struct CommandHelp {
  std::string name;  // "emberline render"
  std::string summary;
  std::vector<OptionHelp> options;
  std::vector<CommandHelp> commands;
};

CommandHelp command_help(const CLI::App& root);

// Man pages.
// man(7) of one command; those below the root have pages of their own, those below them a section.
std::string manual_page(const CommandHelp& command);
// "emberline-render.1"
std::string manual_name(const CommandHelp& command);

// What a shell completes after `emberline`: commands, options, names that an option takes, files by
// their suffix.
// To be sourced; needs bash 4 and no other file.
std::string bash_completion(const CommandHelp& root);
// For a folder of $fpath, as _emberline.
std::string zsh_completion(const CommandHelp& root);

}  // namespace emberline
