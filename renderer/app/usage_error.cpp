#include "renderer/app/usage_error.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

std::vector<std::string> option_names(const CLI::App& app, bool include_short) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    if (include_short) {
      for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    }
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// Returns a name such as "emberline farm status".
std::string full_command_name(const CLI::App& app) {
  const std::string parent_names =
      app.get_parent() ? full_command_name(*app.get_parent()) + " " : "";
  return parent_names + app.get_name();
}

// Returns our option for a name that other renderers use, or an empty string.
std::string_view own_name_of(std::string_view word) {
  constexpr std::pair<std::string_view, std::string_view> kNames[] = {
      {"--resolution", "--size"},   {"--width", "--size"},
      {"--height", "--size"},       {"--samples", "--spp"},
      {"--bounces", "--max-depth"}, {"--depth", "--max-depth"},
      {"--hdri", "--env"},          {"--noise-level", "--noise-threshold"},
      {"--aperture", "--f-stop"},   {"--fov", "--fov-y"},
      {"--region", "--crop"},       {"--cropwindow", "--crop"},
      {"--nthreads", "--threads"},  {"--jobs", "--threads"},
  };
  for (const auto& [other, own] : kNames) {
    if (word == other) return own;
  }
  return {};
}

}  // namespace

void throw_unknown_option(const std::string& word, const std::vector<std::string>& valid,
                          const std::string& command) {
  const std::vector<std::string_view> views(valid.begin(), valid.end());
  const std::string_view known = own_name_of(word);
  const std::string nearest = std::ranges::find(views, known) != views.end()
                                  ? fmt::format("'{}'", known)
                                  : nearest_names(word, views);
  throw UsageError("unknown option '{}'{}; see {} --help-all", shortened(word),
                   nearest.empty() ? "" : fmt::format(" (did you mean {}?)", nearest), command);
}

void throw_usage(const CLI::App& root, const CLI::ParseError& error) {
  const CLI::App* app = &root;
  while (!app->get_subcommands().empty()) app = app->get_subcommands().back();
  const std::string what = error.what();
  // A mistyped option may be the reason why a required argument is missing.
  const bool extras = dynamic_cast<const CLI::ExtrasError*>(&error) ||
                      dynamic_cast<const CLI::RequiredError*>(&error);
  if (extras && !app->remaining().empty()) {
    const std::string unknown = app->remaining().front();
    if (unknown.starts_with("-") && unknown != "-") {
      throw_unknown_option(unknown.substr(0, unknown.find('=')),
                           option_names(*app, !unknown.starts_with("--")), full_command_name(*app));
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
    const std::string name = full_command_name(*app);
    throw UsageError("{}: missing argument: {}; see {} --help", name.substr(name.find(' ') + 1),
                     what, name);
  }
  throw UsageError(what);
}

}  // namespace emberline
