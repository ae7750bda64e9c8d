#include "renderer/app/manual/command_help.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

namespace emberline {
namespace {

bool is_lower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }

// Finds file suffixes, as in ".gltf or .glb" or ".png, .jpg". Ignores suffixes at the end of a name
// ("FILE.checkpoint").
std::vector<std::string> suffixes_in(const std::string& text) {
  std::vector<std::string> found;
  for (size_t dot = text.find('.'); dot != std::string::npos; dot = text.find('.', dot + 1)) {
    if (dot > 0 && text[dot - 1] != ' ') continue;
    const auto begin = text.begin() + std::ptrdiff_t(dot) + 1;
    const std::string suffix(begin, std::find_if_not(begin, text.end(), is_lower));
    if (!suffix.empty() && std::ranges::find(found, suffix) == found.end()) found.push_back(suffix);
  }
  return found;
}

// Adds the literal values of the option's type, such as "all" for "NAME|INDEX|all".
void add_literals(OptionHelp& help) {
  std::istringstream words(help.type);
  for (std::string word; std::getline(words, word, '|');) {
    if (std::ranges::all_of(word, is_lower)) help.values.emplace_back(word, "");
  }
}

// Appends a sentence for each of `options`. These are the options that, according to CLI11, one
// option requires or excludes.
void add_sentence(std::string& text, const char* begin, const std::set<CLI::Option*>& options) {
  for (const CLI::Option* other : options) text += begin + other->get_name() + ".";
}

OptionHelp option_help(const CLI::Option& option) {
  OptionHelp help;
  help.section = option.get_group();
  help.brief = option.get_option_text();
  help.fallback = option.get_default_str();
  for (const std::string& name : option.get_snames()) help.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) help.names.push_back("--" + name);
  help.argument = help.names.empty();
  if (help.argument) help.names.push_back(option.get_name(true));
  if (option.get_items_expected_max() > 0) help.type = option.get_type_name();
  help.required = option.get_required();
  help.repeats = option.get_expected_max() > 1;

  // The description is a paragraph, then lines "  name: summary" (from table_lines()) and
  // "Example: ..." (from describe()).
  std::istringstream lines(option.get_description());
  std::getline(lines, help.text);
  constexpr std::string_view kExample = "Example: ";
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kExample)) {
      help.example = line.substr(kExample.size());
      continue;
    }
    const size_t colon = line.find(": ");
    help.values.emplace_back(line.substr(2, colon - 2), line.substr(colon + 2));
  }
  add_sentence(help.text, " Requires ", option.get_needs());
  add_sentence(help.text, " Cannot be combined with ", option.get_excludes());
  if (help.values.empty()) add_literals(help);
  if (help.type == "FILE" || help.argument) help.suffixes = suffixes_in(help.text);
  return help;
}

}  // namespace

std::string upper_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::toupper(c)); });
  return text;
}

CommandHelp command_help(const CLI::App& app, const std::string& parent_names) {
  CommandHelp help;
  help.name = parent_names + app.get_name();
  help.summary = app.get_description();
  std::istringstream examples(app.get_footer());
  for (std::string line; std::getline(examples, line);) help.examples.push_back(line);
  for (const CLI::Option* option : app.get_options()) {
    const bool hidden = option->get_group().empty();
    if (!hidden) help.options.push_back(option_help(*option));
  }
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    help.commands.push_back(command_help(*command, help.name + " "));
  }
  return help;
}

}  // namespace emberline
