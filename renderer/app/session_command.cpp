#include "renderer/app/commands.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <vector>

#include "renderer/app/command_options.h"
#include "renderer/app/usage_error.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/shortened.h"
#include "renderer/session/overlay_picture.h"
#include "renderer/session/session_host.h"

namespace emberline {
namespace {

HostSettings settings_of(const SessionOptions& options) {
  HostSettings settings;
  ViewSettings& view = settings.view;
  view.render = options.render;
  view.display = options.render.display;
  view.light_groups = options.render.light_groups;
  const OverlayEntry& overlay =
      find_named(overlay_table(), "--overlay", "overlay", options.overlay);
  view.overlay = ViewOverlay(&overlay - overlay_table().data());
  view.region = options.region;
  view.crop = options.render.crop;
  view.paused = options.paused;
  view.denoise = options.denoise;
  settings.display = options.format == "display";
  return settings;
}

// Parses the host's settings as options, which override the options of the command line.
HostSettings parse_host_settings(SessionOptions options, const HostTexts& texts) {
  CLI::App app("", "emberline session");
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.set_help_flag("");
  add_session_options(&app, options);
  std::vector<std::string> arguments;
  for (const auto& [name, text] : texts) {
    const bool is_valid_name =
        std::ranges::all_of(name, [](unsigned char c) { return c == '-' || std::islower(c); });
    if (!is_valid_name || name.empty()) throw UsageError("unknown setting '{}'", shortened(name));
    const CLI::Option* const option = app.get_option_no_throw("--" + name);
    const bool is_switch = option && option->get_items_expected_max() == 0;
    if (is_switch && text != "yes" && text != "no") {
      throw UsageError("--{}: '{}' is neither true nor false", name, shortened(text));
    }
    arguments.push_back("--" + name + "=" + text);
  }
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    throw_usage(app, error);
  }
  return settings_of(options);
}

}  // namespace

int run_session(const SessionOptions& options) {
  run_session_host([&](const HostTexts& texts) { return parse_host_settings(options, texts); },
                   STDIN_FILENO, STDOUT_FILENO);
  return kExitDone;
}

}  // namespace emberline
