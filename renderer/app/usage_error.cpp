#include "renderer/app/usage_error.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

}  // namespace

void throw_usage(const CLI::App& root, const CLI::ParseError& error) {
  const CLI::App* app = &root;
  while (!app->get_subcommands().empty()) app = app->get_subcommands().back();
  const std::string what = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !app->remaining().empty()) {
    const std::string unknown = app->remaining().front();
    if (unknown.starts_with("-") && unknown != "-") {
      throw UsageError(
          unknown_word_message("option", unknown.substr(0, unknown.find('=')), option_names(*app)));
    }
    if (app != &root) throw UsageError("unexpected argument '{}'", shortened(unknown));
    std::vector<std::string> commands;
    for (const CLI::App* sub : root.get_subcommands(nullptr)) commands.push_back(sub->get_name());
    throw UsageError(unknown_word_message("command", unknown, commands));
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) {
    const std::string name = what.substr(0, what.find(':'));
    const CLI::Option* option = app->get_option_no_throw(name);
    throw UsageError("{} needs a value{}", name,
                     option && !option->get_type_name().empty()
                         ? ": " + name + " " + option->get_type_name()
                         : "");
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) && app != &root) {
    const bool nested = app->get_parent() != &root;
    const std::string name = (nested ? app->get_parent()->get_name() + " " : "") + app->get_name();
    throw UsageError("{}: missing argument: {}; see emberline {} --help", name, what, name);
  }
  throw UsageError(what);
}

}  // namespace emberline
