#include <CLI/CLI.hpp>
#include <algorithm>

#include "renderer/app/commands.h"
#include "renderer/app/manual/command_help.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"

namespace emberline {
namespace {

const CommandHelp* find_subcommand(const CommandHelp& command, const std::string& word) {
  const auto found =
      std::ranges::find(command.commands, command.name + " " + word, &CommandHelp::name);
  return found == command.commands.end() ? nullptr : &*found;
}

}  // namespace

int run_help(const HelpOptions& options) {
  std::vector<std::string> words = options.words;
  // CLI11 does not accept a word with dashes, such as `--env`, as a value. Such words are in
  // remaining().
  for (const CLI::App* app : options.root->get_subcommands()) {
    for (const std::string& extra : app->remaining()) words.push_back(extra);
  }
  const CommandHelp root = command_help(*options.root);
  const CommandHelp* command = &root;
  for (size_t i = 0; i < words.size(); ++i) {
    if (const CommandHelp* subcommand = find_subcommand(*command, words[i])) {
      command = subcommand;
      continue;
    }
    if (command->is_root()) {
      std::vector<std::string> names;
      for (const CommandHelp& each : root.commands) {
        names.push_back(each.name.substr(root.name.size() + 1));
      }
      throw UsageError(unknown_word_message("command", words[i], names));
    }
    if (i + 1 < words.size()) throw UsageError("help takes a command and one of its options");
    print_result(option_page(*command, words[i]));
    return kExitDone;
  }
  print_result(brief_help(*command));
  return kExitDone;
}

}  // namespace emberline
