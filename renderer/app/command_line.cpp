#include "renderer/app/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <ranges>
#include <set>

#include "io/files/atomic_file.h"
#include "renderer/app/command_options.h"
#include "renderer/app/failure.h"
#include "renderer/app/manual/command_help.h"
#include "renderer/app/manual/completion.h"
#include "renderer/app/manual/manual.h"
#include "renderer/app/render_command.h"
#include "renderer/app/session_command.h"
#include "renderer/app/shell_quote.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/app/usage_error.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/option_values.h"
#include "renderer/core/setting_names.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/report.h"

namespace emberline {
namespace {

// An empty text (`--env "$UNSET"`) would mean later that the option was not given. Lists, and names
// that the option's help lists, are looked up, which says what is valid.
void refuse_empty_values(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name(), name = option->get_name(false, true);
    const bool looked_up =
        type == "LIST" || option->get_description().find('\n') != std::string::npos;
    if (looked_up || std::ranges::find(option->results(), "") == option->results().end()) continue;
    throw UsageError("{} needs a value, and the one given is empty: {} {}", name, name, type);
  }
  for (const CLI::App* sub : app.get_subcommands()) refuse_empty_values(*sub);
}

// The options of every subcommand; those of the one that is given are filled.
struct AllOptions {
  RenderOptions render;
  ViewOptions view;
  InfoOptions info;
  HeatmapOptions heatmap;
  CompareOptions compare;
  DenoiseOptions denoise;
  StudyOptions study;
  MergeOptions merge;
  ExtendOptions extend;
  FarmOptions farm;
  SessionOptions session;
};

struct Command {
  const char* name;
  const char* help;
  void (*add_options)(CLI::App*, AllOptions&);
  int (*run)(const AllOptions&);
};

const Command kCommands[] = {
    {"render", "render a scene to pictures",
     [](CLI::App* app, AllOptions& o) { add_render_options(app, o.render); },
     [](const AllOptions& o) { return run_render(o.render); }},
    {"view", "the interactive window",
     [](CLI::App* app, AllOptions& o) { add_view_options(app, o.view); },
     [](const AllOptions& o) {
       ViewOptions view = o.view;
       view.stopped = stop_signalled;
       return run_view(view);
     }},
    {"session", "the window's session for another program, over a pipe and shared memory",
     [](CLI::App* app, AllOptions& o) { add_session_options(app, o.session); },
     [](const AllOptions& o) { return run_session(o.session); }},
    {"info", "what is in a scene and what becomes of it",
     [](CLI::App* app, AllOptions& o) { add_info_options(app, o.info); },
     [](const AllOptions& o) { return run_info(o.info); }},
    {"heatmap", "sample density, error, reasons or time of a frame as a picture",
     [](CLI::App* app, AllOptions& o) { add_heatmap_options(app, o.heatmap); },
     [](const AllOptions& o) { return run_heatmap(o.heatmap); }},
    {"compare", "measure an image against a reference",
     [](CLI::App* app, AllOptions& o) { add_compare_options(app, o.compare); },
     [](const AllOptions& o) { return run_compare(o.compare); }},
    {"denoise", "a clean picture of a finished frame",
     [](CLI::App* app, AllOptions& o) { add_denoise_options(app, o.denoise); },
     [](const AllOptions& o) { return run_denoise(o.denoise); }},
    {"extend", "a finished frame to more samples or a lower threshold",
     [](CLI::App* app, AllOptions& o) { add_extend_options(app, o.extend); },
     [](const AllOptions& o) { return run_extend(o.extend); }},
    {"merge", "the parts of a frame as one picture",
     [](CLI::App* app, AllOptions& o) { add_merge_options(app, o.merge); },
     [](const AllOptions& o) { return run_merge(o.merge); }},
    {"farm", "a frame in parts, as jobs of Slurm; farm status, cancel, retry",
     [](CLI::App* app, AllOptions& o) { add_farm_options(app, o.farm); },
     [](const AllOptions& o) { return run_farm(o.farm); }},
    {"study", "speed against error of drivers, estimators and samplers",
     [](CLI::App* app, AllOptions& o) { add_study_options(app, o.study); },
     [](const AllOptions& o) { return run_study(o.study); }},
};

void write_document(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  AtomicFile file(path);
  file.write_at(text.data(), text.size(), 0);
  file.commit();
}

// Where they lie below a prefix's share.
void write_documents(const CommandHelp& root, const std::filesystem::path& folder) {
  write_document(folder / "man/man1" / manual_name(root), manual_page(root));
  for (const CommandHelp& command : root.commands) {
    write_document(folder / "man/man1" / manual_name(command), manual_page(command));
  }
  write_document(folder / "bash-completion/completions/emberline", bash_completion(root));
  write_document(folder / "zsh/vendor-completions/_emberline", zsh_completion(root));
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

std::string spelled_as_option(std::string_view name) {
  return option_names().contains(name) ? fmt::format("--{}", name) : "";
}

// From here on messages name settings as options, as help texts do.
void spell_as_options(const std::vector<CLI::App*>& commands) {
  std::vector<CLI::Option*> options;
  for (CLI::App* command : commands) {
    for (CLI::Option* option : command->get_options()) options.push_back(option);
  }
  for (const CLI::Option* option : options) {
    for (const std::string& name : option->get_lnames()) option_names().insert(name);
  }
  spell_settings(spelled_as_option);
  for (CLI::Option* option : options) option->description(spelled(option->get_description()));
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App root("Emberline: a path tracer for glTF scenes", "emberline");
  root.require_subcommand(0, 1);
  // As everywhere: of an option given twice the last counts, so that a script's defaults can be
  // overridden behind them.
  root.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  bool version = false, quiet = false, verbose = false;
  root.add_flag(
      "--version", version,
      "print the versions of the program and its libraries, and what they use of the processor");
  root.add_flag("-v,--verbose", verbose, "beside --version: the same")->group("");  // hidden
  std::string documents;
  root.add_option("--write-documents", documents, "man pages and completion, for packages")
      ->group("");  // hidden
  AllOptions options;
  std::vector<CLI::App*> commands;
  for (const Command& command : kCommands) {
    CLI::App* app = root.add_subcommand(command.name, command.help);
    command.add_options(app, options);
    std::vector<CLI::App*> all = app->get_subcommands(nullptr);
    all.push_back(app);
    for (CLI::App* each : all) {
      CLI::Option* q = each->add_flag("-q,--quiet", quiet, "errors only");
      each->add_flag("-v,--verbose", verbose, "say what is built and why")->excludes(q);
    }
    commands.insert(commands.end(), all.begin(), all.end());
  }
  spell_as_options(commands);

  try {
    root.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return root.exit(success);  // --help
  } catch (const CLI::ParseError& error) {
    throw_usage(root, error);
  }
  for (const CLI::App* app : root.get_subcommands()) refuse_empty_values(*app);
  set_log_level(quiet ? LogLevel::kQuiet : verbose ? LogLevel::kVerbose : LogLevel::kNormal);
  options.render.command_line = options.view.render.command_line =
      options.study.frame.command_line = options.merge.frame.command_line =
          options.extend.more.command_line = shell_command(argc, argv);

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
  throw UsageError("no command given; valid commands are {}; see emberline --help",
                   fmt::join(kCommands | std::views::transform(&Command::name), ", "));
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
