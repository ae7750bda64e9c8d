#include "renderer/app/manual/command_help.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace emberline {
namespace {

using Words = std::vector<std::string>;

Words value_names(const OptionHelp& option) {
  Words names;
  for (const auto& [name, meaning] : option.values) names.push_back(name);
  return names;
}

Words command_names(const std::vector<CommandHelp>& commands) {
  Words names;
  for (const CommandHelp& each : commands) {
    names.push_back(each.name.substr(each.name.rfind(' ') + 1));
  }
  return names;
}

bool names_file(const OptionHelp& option) { return option.type == "FILE" || option.argument; }

// Returns bash code that completes the option's value.
std::string bash_value(const OptionHelp& option) {
  if (!option.values.empty()) {
    return fmt::format("{}='{}'", option.type == "LIST" ? "list" : "words",
                       fmt::join(value_names(option), " "));
  }
  if (option.type == "DIR") return "files=(/)";  // a pattern that no file name matches
  if (!names_file(option)) return "return";
  if (option.suffixes.empty()) return "files=('*')";
  return fmt::format("files=('*.{}')", fmt::join(option.suffixes, "' '*."));
}

std::string bash_command(const CommandHelp& command, const std::string& pattern) {
  Words options;
  std::string cases, argument;
  for (const OptionHelp& option : command.options) {
    if (option.argument) {
      argument = bash_value(option);
      continue;
    }
    options.insert(options.end(), option.names.begin(), option.names.end());
    if (option.type.empty()) continue;
    cases += fmt::format("        {}) {} ;;\n", fmt::join(option.names, " | "), bash_value(option));
  }
  // `farm` takes a scene or a subcommand.
  if (!command.commands.empty()) {
    if (!argument.empty()) argument += "; ";
    argument += fmt::format("words='{}'", fmt::join(command_names(command.commands), " "));
  }
  if (argument.empty()) argument = "return";
  return fmt::format(
      "    {})\n      case $last in\n{}        *) if [[ $cur == -* ]]; then words='{}'; else {}; "
      "fi "
      ";;\n      esac\n      ;;\n",
      pattern, cases, fmt::join(options, " "), argument);
}

constexpr const char* kBashHead = R"(# Written by emberline from its own options.
_emberline() {
  local cur=${COMP_WORDS[COMP_CWORD]} last=${COMP_WORDS[COMP_CWORD - 1]}
  local command= words= list= head= files=() i
  COMPREPLY=()
  if [[ $cur == = ]]; then  # "--env=" is two words, "--env=x" three
    cur=
  elif [[ $last == = ]]; then
    last=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case $command${command:+ }${COMP_WORDS[i]} in
)";

constexpr const char* kBashTail = R"(  esac
  if [[ $list ]]; then  # behind the last comma
    [[ $cur == *,* ]] && head=${cur%,*},
    mapfile -t COMPREPLY < <(compgen -P "$head" -W "$list" -- "${cur##*,}")
    compopt -o nospace 2>/dev/null
  elif ((${#files[@]})); then
    cur=${cur#[\"\']}
    cur=${cur//\\/}
    mapfile -t COMPREPLY < <(
      compgen -d -- "$cur"
      compgen -W "$words" -- "$cur"
      for i in "${files[@]}"; do compgen -f -X "!$i" -- "$cur"; done
    )
    compopt -o filenames 2>/dev/null
  else
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
  fi
}
complete -F _emberline emberline
)";

// Returns the first sentence or clause of `text`. Escapes it for use within single quotes and
// within the [...] of zsh's _arguments.
std::string zsh_text(const std::string& text) {
  std::string out;
  const size_t sentence = std::min(text.find(". "), text.size());
  for (const char c : text.substr(0, std::min(sentence, text.find_first_of(";:[")))) {
    out += c == '\'' ? "'\\''" : c == ']' ? "\\]" : std::string(1, c);
  }
  return out.substr(0, out.find_last_not_of(" .") + 1);
}

std::string zsh_value(const OptionHelp& option) {
  const std::string names = fmt::format("{}", fmt::join(value_names(option), " "));
  if (!names.empty() && option.type == "LIST") return "_values -s , name " + names;
  if (!names.empty()) return "(" + names + ")";
  if (option.type == "DIR") return "_files -/";
  if (!names_file(option)) return " ";
  if (option.suffixes.empty()) return "_files";
  return fmt::format("_files -g \"*.({})\"", fmt::join(option.suffixes, "|"));
}

// `farm` takes a scene, or a subcommand followed by an output.
std::string zsh_argument(const OptionHelp& option, const Words& commands) {
  const std::string& name = option.names.front();
  const std::string value = zsh_value(option);
  if (commands.empty()) return fmt::format("'{}:{}:{}'", option.repeats ? "*" : "", name, value);
  return fmt::format("'1:{}:{{compadd {}; {}}}' '*:file:_files'", name, fmt::join(commands, " "),
                     value);
}

std::string zsh_option(const OptionHelp& option) {
  const std::string others = fmt::format("({})", fmt::join(option.names, " "));
  const std::string value = option.type.empty() ? "" : ":" + option.type + ":" + zsh_value(option);
  Words specs;
  for (const std::string& name : option.names) {
    const bool equals = !option.type.empty() && name.starts_with("--");
    specs.push_back(
        fmt::format("'{}{}{}[{}]{}'", option.repeats ? "*" : others, name, equals ? "=" : "",
                    zsh_text(option.brief.empty() ? option.text : option.brief), value));
  }
  return fmt::format("{}", fmt::join(specs, " "));
}

std::string zsh_options(const CommandHelp& command) {
  std::string text;
  for (const OptionHelp& option : command.options) {
    text +=
        " \\\n        " + (option.argument ? zsh_argument(option, command_names(command.commands))
                                           : zsh_option(option));
  }
  return text;
}

}  // namespace

std::string bash_completion(const CommandHelp& root) {
  std::string text = kBashHead, cases = bash_command(root, "''");
  const auto add = [&](const CommandHelp& command) {
    const std::string name = command.name.substr(root.name.size() + 1);
    text += fmt::format("      '{0}') command='{0}' ;;\n", name);
    cases += bash_command(command, "'" + name + "'");
  };
  for (const CommandHelp& command : root.commands) {
    add(command);
    std::ranges::for_each(command.commands, add);
  }
  return text + "    esac\n  done\n  case $command in\n" + cases + kBashTail;
}

std::string zsh_completion(const CommandHelp& root) {
  std::string text =
      "#compdef emberline\n# Written by emberline from its own options.\n"
      "_emberline() {\n  local context state line curcontext=$curcontext\n  local -a commands=(\n";
  std::string cases;
  const Words names = command_names(root.commands);
  for (size_t i = 0; i < names.size(); ++i) {
    const CommandHelp& command = root.commands[i];
    text += fmt::format("    '{}:{}'\n", names[i], zsh_text(command.summary));
    cases += fmt::format("      {})\n        _arguments -s{} ;;\n", names[i], zsh_options(command));
  }
  return text + "  )\n  _arguments -C" + zsh_options(root) +
         " \\\n        '1:command:->command' '*::argument:->argument'\n"
         "  case $state in\n    command) _describe command commands ;;\n"
         "    argument) case $words[1] in\n" +
         cases + "      esac ;;\n  esac\n}\n_emberline \"$@\"\n";
}

}  // namespace emberline
