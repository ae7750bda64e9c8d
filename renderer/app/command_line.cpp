#include "renderer/app/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <set>

#include "io/files/atomic_file.h"
#include "renderer/app/command_options.h"
#include "renderer/app/commands.h"
#include "renderer/app/failure.h"
#include "renderer/app/manual/command_help.h"
#include "renderer/app/shared_options.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/app/usage_error.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/option_values.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/shell_quote.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/report.h"

namespace emberline {
namespace {

// Throws UsageError for an empty value (`--env "$UNSET"`), because it would later look like an
// absent option. Skips lists and named choices, because their own checks report the valid values.
void reject_empty_values(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name(), name = option->get_name(false, true);
    const bool is_named_choice =
        type == "LIST" || option->get_description().find("\n  ") != std::string::npos;
    if (is_named_choice || std::ranges::find(option->results(), "") == option->results().end())
      continue;
    throw UsageError("{} needs a value, but the given one is empty: {} {}", name, name, type);
  }
  for (const CLI::App* sub : app.get_subcommands()) reject_empty_values(*sub);
}

// The options of all subcommands. Only those of the chosen subcommand are filled in.
struct AllOptions {
  RenderOptions render;
  ViewOptions view;
  InfoOptions info;
  HeatmapOptions heatmap;
  ShowOptions show;
  ExplainOptions explain;
  CompareOptions compare;
  DenoiseOptions denoise;
  StudyOptions study;
  PlanOptions plan;
  MergeOptions merge;
  ExtendOptions extend;
  FarmOptions farm;
  SessionOptions session;
  HelpOptions help;
};

struct Command {
  const char* name;
  const char* help;
  void (*add_options)(CLI::App*, AllOptions&);
  int (*run)(const AllOptions&);
};

template <auto kOptions, auto kAdd, auto kRun>
constexpr Command command(const char* name, const char* help) {
  return {name, help, [](CLI::App* app, AllOptions& o) { kAdd(app, o.*kOptions); },
          [](const AllOptions& o) { return kRun(o.*kOptions); }};
}

int run_stoppable_view(ViewOptions view) {
  view.stopped = stop_signalled;
  return run_view(view);
}

using All = AllOptions;
constexpr Command kCommands[] = {
    command<&All::render, add_render_options, run_render>("render", "Render a scene to pictures."),
    command<&All::view, add_view_options, run_stoppable_view>(
        "view", "Show a scene in a window while it renders."),
    command<&All::session, add_session_options, run_session>(
        "session", "Serve another program, such as Blender, over a pipe and shared memory."),
    command<&All::info, add_info_options, run_info>(
        "info",
        "List the contents of a scene or of a frame, and glTF features that are approximated or "
        "ignored."),
    command<&All::show, add_show_options, run_show>(
        "show", "Convert a frame, or one of its layers, to a picture for display."),
    command<&All::heatmap, add_heatmap_options, run_heatmap>(
        "heatmap", "Draw the samples, error or time of each pixel of a finished frame."),
    command<&All::explain, add_explain_options, run_explain>(
        "explain", "Explain why a pixel of a finished frame got its number of samples."),
    command<&All::compare, add_compare_options, run_compare>(
        "compare", "Measure a picture against a reference."),
    command<&All::denoise, add_denoise_options, run_denoise>("denoise",
                                                             "Denoise a finished frame."),
    command<&All::extend, add_extend_options, run_extend>(
        "extend", "Add samples to a finished frame, or lower its noise threshold."),
    command<&All::plan, add_plan_options, run_plan>(
        "plan",
        "Decide the sample counts of an adaptive frame, so that it can be rendered in parts."),
    command<&All::merge, add_merge_options, run_merge>("merge", "Join the parts of a frame."),
    command<&All::farm, add_farm_options, run_farm>("farm",
                                                    "Render a frame in parts, as Slurm jobs."),
    command<&All::study, add_study_options, run_study>(
        "study", "Measure the speed and error of drivers, estimators and samplers."),
    command<&All::help, add_help_options, run_help>(
        "help", "Explain all commands, a command, or one of its options."),
};

void write_document(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  write_file_atomically(path.string(), text);
}

// Writes the man pages, the shell completions and the generated pages of the manual. `folder` then
// has the layout of the share folder of an installation.
void write_documents(const CommandHelp& root, const std::filesystem::path& folder) {
  write_document(folder / "man/man1" / manual_name(root), manual_page(root));
  for (const CommandHelp& command : root.commands) {
    write_document(folder / "man/man1" / manual_name(command), manual_page(command));
  }
  write_document(folder / "bash-completion/completions/emberline", bash_completion(root));
  write_document(folder / "zsh/vendor-completions/_emberline", zsh_completion(root));
  write_document(folder / "doc/options.md", options_page(root));
  write_document(folder / "doc/channels.md", channels_page());
}

void print_versions() {
  std::string text;
  for (const auto& [name, number] : library_versions()) text += name + " " + number + "\n";
  text += "instruction sets: " + instruction_sets() + "\n";
  print_result(text);
}

std::set<std::string, std::less<>>& option_names() {
  static std::set<std::string, std::less<>> names;
  return names;
}

std::string format_as_option(std::string_view name) {
  return option_names().contains(name) ? fmt::format("--{}", name) : "";
}

// Makes messages and help texts spell settings as command-line options.
void use_option_names(const std::vector<CLI::App*>& commands) {
  std::vector<CLI::Option*> options;
  for (CLI::App* command : commands) {
    for (CLI::Option* option : command->get_options()) options.push_back(option);
  }
  for (const CLI::Option* option : options) {
    for (const std::string& name : option->get_lnames()) option_names().insert(name);
  }
  spell_settings(format_as_option);
  for (CLI::Option* option : options) {
    option->description(spell_setting_names(option->get_description()));
    option->option_text(spell_setting_names(option->get_option_text()));
    option->default_str(spell_setting_names(option->get_default_str()));
  }
}

// Prints the few commands that most people need.
void print_welcome() {
  std::fputs(
      "Emberline renders glTF scenes by path tracing.\n\n"
      "  emberline render scene.glb -o picture.png    render a scene to a picture\n"
      "  emberline view scene.glb                     show a scene in a window\n"
      "  emberline info scene.glb                     list what a scene contains\n\n"
      "See all commands with: emberline help\n",
      stderr);
}

void add_help_flags(CLI::App& app) {
  describe(app.set_help_flag("-h,--help"),
           {.section = HelpSection::kGeneral, .full = "Show the common options."});
  describe(app.set_help_all_flag("--help-all"),
           {.section = HelpSection::kGeneral, .full = "Show all options in full."});
}

void add_common_options(CLI::App& app, bool& quiet, bool& verbose) {
  CLI::Option* q = add_flag(&app, "-q,--quiet", quiet,
                            {.section = HelpSection::kGeneral, .full = "Print errors only."});
  add_flag(&app, "-v,--verbose", verbose,
           {.section = HelpSection::kGeneral, .full = "Print what is built and why."})
      ->excludes(q);
  add_help_flags(app);
}

// Lists the commands as the values that `emberline help` takes, for completion.
std::string command_lines() {
  std::string text;
  for (const Command& command : kCommands) {
    text += fmt::format("\n  {}: {}", command.name, command.help);
  }
  return text;
}

// Returns the innermost subcommand that was given.
const CLI::App& chosen_command(const CLI::App& root) {
  const CLI::App* app = &root;
  while (!app->get_subcommands().empty()) app = app->get_subcommands().back();
  return *app;
}

CommandHelp help_of(const CLI::App& app) {
  std::string parent_names;
  for (const CLI::App* parent = app.get_parent(); parent; parent = parent->get_parent()) {
    parent_names = parent->get_name() + " " + parent_names;
  }
  return command_help(app, parent_names);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App root("Emberline renders glTF scenes by path tracing.", "emberline");
  root.require_subcommand(0, 1);
  // The last occurrence of an option wins, so that a script's defaults can be overridden by
  // appending options.
  root.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  bool version = false, quiet = false, verbose = false;
  add_help_flags(root);
  add_flag(&root, "--version", version,
           {.section = HelpSection::kGeneral,
            .brief = "print the versions of the program and its libraries",
            .full = "Print the versions of the program and its libraries, and the instruction sets "
                    "that they use."});
  root.add_flag("-v,--verbose", verbose, "accepted with --version, without effect")
      ->group("");  // hidden
  std::string documents;
  root.add_option("--write-documents", documents,
                  "man pages, completion and pages of the manual, for packages")
      ->group("");  // hidden
  AllOptions options;
  options.help.root = &root;
  std::vector<CLI::App*> commands;
  for (const Command& command : kCommands) {
    CLI::App* app = root.add_subcommand(command.name, command.help);
    command.add_options(app, options);
    std::vector<CLI::App*> all = app->get_subcommands(nullptr);
    all.push_back(app);
    for (CLI::App* each : all) add_common_options(*each, quiet, verbose);
    commands.insert(commands.end(), all.begin(), all.end());
  }
  CLI::Option* command_argument = root.get_subcommand("help")->get_option("command");
  command_argument->description(command_argument->get_description() + command_lines());
  use_option_names(commands);

  try {
    root.parse(argc, argv);
  } catch (const CLI::CallForAllHelp&) {
    print_result(full_help(help_of(chosen_command(root))));
    return kExitDone;
  } catch (const CLI::CallForHelp&) {
    print_result(brief_help(help_of(chosen_command(root))));
    return kExitDone;
  } catch (const CLI::ParseError& error) {
    throw_usage(root, error);
  }
  for (const CLI::App* app : root.get_subcommands()) reject_empty_values(*app);
  set_log_level(quiet ? LogLevel::kQuiet : verbose ? LogLevel::kVerbose : LogLevel::kNormal);
  options.render.command_line = options.view.render.command_line =
      options.study.frame.command_line = options.merge.frame.command_line =
          options.extend.overrides.command_line = shell_command(argc, argv);

  if (version) {
    print_versions();
    return kExitDone;
  }
  if (!documents.empty()) {
    write_documents(command_help(root), documents);
    return kExitDone;
  }
  for (const Command& command : kCommands) {
    if (root.got_subcommand(command.name)) return command.run(options);
  }
  print_welcome();
  return kExitUsage;
}

int run_program(int argc, char** argv) {
  replace_closed_streams();
  install_stop_handlers();
  install_refused_thread_handler();
  try {
    return run_command_line(argc, argv);
  } catch (const std::exception& error) {
    const Failure failure = failure_of(error);
    log_error(failure.message);
    return failure.exit_code;
  }
}

}  // namespace emberline
