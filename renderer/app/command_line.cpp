#include "renderer/app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <new>

#include "renderer/app/command_options.h"
#include "renderer/app/render_command.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/option_values.h"
#include "renderer/output/report.h"
#include "renderer/process/shell_quote.h"
#include "renderer/process/standard_output.h"
#include "renderer/process/stop_signal.h"
#include "renderer/process/worker_threads.h"

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

// What CLI11 found wrong, in our words: one line that names the option and what is valid.
[[noreturn]] void throw_usage(const CLI::App& root, const CLI::ParseError& error) {
  const CLI::App* app = &root;
  for (const CLI::App* sub : root.get_subcommands()) app = sub;
  const std::string what = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !app->remaining().empty()) {
    const std::string unknown = app->remaining().front();
    if (unknown.starts_with("-") && unknown != "-") {
      throw UsageError(
          unknown_word_message("option", unknown.substr(0, unknown.find('=')), option_names(*app)));
    }
    if (app != &root) throw UsageError("unexpected argument '" + unknown + "'");
    std::vector<std::string> commands;
    for (const CLI::App* sub : root.get_subcommands(nullptr)) commands.push_back(sub->get_name());
    throw UsageError(unknown_word_message("command", unknown, commands));
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error)) {
    const std::string name = what.substr(0, what.find(':'));
    const CLI::Option* option = app->get_option_no_throw(name);
    throw UsageError(name + " needs a value" +
                     (option && !option->get_type_name().empty()
                          ? ": " + name + " " + option->get_type_name()
                          : ""));
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) && app != &root) {
    throw UsageError(app->get_name() + ": missing argument: " + what + "; see emberline " +
                     app->get_name() + " --help");
  }
  throw UsageError(what);
}

// An empty text (`--env "$UNSET"`) would mean later that the option was not given. Lists, and names
// that the option's help lists, are looked up, which says what is valid.
void refuse_empty_values(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name(), name = option->get_name(false, true);
    const bool looked_up =
        type == "LIST" || option->get_description().find('\n') != std::string::npos;
    if (looked_up || std::ranges::find(option->results(), "") == option->results().end()) continue;
    throw UsageError(name + " needs a value, and the one given is empty: " + name + " " + type);
  }
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App root("Emberline: a path tracer for glTF scenes", "emberline");
  root.require_subcommand(0, 1);
  // As everywhere: of an option given twice the last counts, so that a script's defaults can be
  // overridden behind them.
  root.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  bool version = false;
  root.add_flag("--version", version, "print the versions of the program and its libraries");

  bool quiet = false, verbose = false;
  const auto add_log_flags = [&](CLI::App* app) {
    CLI::Option* q = app->add_flag("-q,--quiet", quiet, "errors only");
    app->add_flag("-v,--verbose", verbose, "say what is built and why")->excludes(q);
  };

  RenderOptions render;
  CLI::App* render_app = root.add_subcommand("render", "render a scene to pictures");
  add_render_options(render_app, render);
  add_log_flags(render_app);

  ViewOptions view;
  CLI::App* view_app = root.add_subcommand("view", "the interactive window");
  add_view_options(view_app, view);
  add_log_flags(view_app);

  InfoOptions info;
  CLI::App* info_app = root.add_subcommand("info", "what is in a scene and what becomes of it");
  add_info_options(info_app, info);
  add_log_flags(info_app);

  HeatmapOptions heatmap;
  CLI::App* heatmap_app = root.add_subcommand(
      "heatmap", "sample density, error, reasons or time of a frame as a picture");
  add_heatmap_options(heatmap_app, heatmap);
  add_log_flags(heatmap_app);

  CompareOptions compare;
  CLI::App* compare_app = root.add_subcommand("compare", "measure an image against a reference");
  add_compare_options(compare_app, compare);
  add_log_flags(compare_app);

  StudyOptions study;
  CLI::App* study_app =
      root.add_subcommand("study", "speed against error of drivers, estimators and samplers");
  add_study_options(study_app, study);
  add_log_flags(study_app);

  try {
    root.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return root.exit(success);  // --help
  } catch (const CLI::ParseError& error) {
    throw_usage(root, error);
  }
  for (const CLI::App* app : root.get_subcommands()) refuse_empty_values(*app);
  set_log_level(quiet ? LogLevel::kQuiet : verbose ? LogLevel::kVerbose : LogLevel::kNormal);
  render.command_line = view.render.command_line = study.frame.command_line =
      shell_command(argc, argv);

  if (version) {
    std::string text;
    for (const auto& [name, number] : library_versions()) text += name + " " + number + "\n";
    print_result(text);
    return kExitDone;
  }
  if (render_app->parsed()) {
    if (render.outputs.empty() && !render.replay) {
      throw UsageError("render needs an output: -o FILE.exr (or .png, .jpg)");
    }
    return run_render(render);
  }
  if (view_app->parsed()) return run_view(view);
  if (study_app->parsed()) {
    if (study.convergence != study.frame.scene.empty()) {
      throw UsageError(study.convergence ? "study --convergence needs no scene, but one is given"
                                         : "study needs a scene: study SCENE -o DIR");
    }
    if (study.folder.empty() && !study.convergence) {
      throw UsageError("study needs a folder for its results: -o DIR");
    }
    return run_study(study);
  }
  // These have no --threads.
  const WorkerThreads workers(0);
  if (info_app->parsed()) return run_info(info);
  if (heatmap_app->parsed()) return run_heatmap(heatmap);
  if (compare_app->parsed()) return run_compare(compare);
  throw UsageError(
      "no command given; valid commands are render, view, info, heatmap, compare, study; see "
      "emberline "
      "--help");
}

int run_program(int argc, char** argv) {
  replace_closed_streams();
  install_stop_handlers();
  install_refused_thread_handler();
  try {
    return run_command_line(argc, argv);
  } catch (const EmberlineError& error) {
    log_error(error.what());
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    log_error("out of memory; render a smaller frame (--size, --crop) or fewer textures");
    return kExitRenderFailed;
  } catch (const std::exception& error) {
    log_error(message_of(error));
    return kExitRenderFailed;
  }
}

}  // namespace emberline
