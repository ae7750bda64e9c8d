#include "renderer/app/shared_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>

#include "renderer/core/shortened.h"
#include "renderer/engine/run_limits.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/output/heatmap_file.h"

namespace emberline {
namespace {

std::string help_of(const Setting& setting, const FrameSettings& settings) {
  std::string help = setting.help;
  const std::string value = setting.text(settings);
  if (!value.empty() && !setting.type.empty()) help += " [" + value + "]";
  const RulesHelp& rules = rules_of(setting);
  return help + rules.rules + rules.values;
}

}  // namespace

CLI::Option* add_parsed(CLI::App* app, const std::string& name, const std::string& type,
                        const std::string& help, const std::string& what,
                        const std::function<bool(const std::string& text)>& read) {
  const auto check = [name, what, read](const std::string& text) {
    if (read(text)) return;
    throw CLI::ValidationError(name, fmt::format("'{}' is not {}", shortened(text), what));
  };
  return app->add_option_function<std::string>(name, check, help)->type_name(type);
}

CLI::Option* add_text(CLI::App* app, const std::string& option, std::string& target,
                      const std::string& type, const std::string& help) {
  return app->add_option(option, target, help)->type_name(type);
}

CLI::Option* add_text(CLI::App* app, const std::string& option, std::optional<std::string>& target,
                      const std::string& type, const std::string& help) {
  return app->add_option(option, target, help)->type_name(type);
}

CLI::Option* add_text(CLI::App* app, const std::string& option, std::vector<std::string>& target,
                      const std::string& type, const std::string& help) {
  return app->add_option(option, target, help)->type_name(type)->allow_extra_args(false);
}

CLI::Option* add_checked_name(CLI::App* app, const std::string& option, std::string& target,
                              const std::function<void(const std::string& name)>& check,
                              const std::string& help) {
  return app->add_option(option, target, help)
      ->type_name("NAME")
      ->check([check](const std::string& name) {
        check(name);
        return std::string();
      });
}

void add_size(CLI::App* app, const std::string& option, std::optional<uint64_t>& bytes,
              const std::string& help) {
  add_parsed(app, option, "SIZE", help, "a size, such as 8G, 500M or 4096",
             [&bytes](const std::string& text) {
               bytes = parse_size(text);
               return bytes.has_value();
             });
}

void add_setting(CLI::App* app, const Setting& setting, FrameSettings& settings) {
  const std::string option = "--" + setting.name;
  if (setting.type.empty()) {
    app->add_flag_function(
        option, [&](int64_t count) { setting.read(settings, count > 0 ? "yes" : "no"); },
        help_of(setting, settings));
    return;
  }
  CLI::Option* added = app->add_option_function<std::string>(
      option, [&](const std::string& text) { setting.read(settings, text); },
      help_of(setting, settings));
  added->type_name(setting.type);
  const bool nodes = setting.type.ends_with(",...");
  if (nodes || setting.type == "LIST") added->join(',');  // --aov albedo --aov N: both
  if (setting.type == "LIST") {
    added->check([option](const std::string& list) {
      return list.empty() ? "needs a value, and the one given is empty: " + option + " LIST" : "";
    });
  }
}

void add_settings(CLI::App* app, FrameSettings& settings,
                  std::initializer_list<SettingGroup> groups,
                  std::initializer_list<std::string_view> left_out) {
  for (const Setting& setting : setting_table()) {
    const bool wanted = std::ranges::find(groups, setting.group) != groups.end() &&
                        std::ranges::find(left_out, setting.name) == left_out.end();
    if (wanted) add_setting(app, setting, settings);
  }
}

void add_settings_file(CLI::App* app, RenderOptions& o) {
  app->add_option_function<std::string>(
         "--settings",
         [&o](const std::string& path) {
           if (path.empty()) return;  // refuse_empty_values() reports it later
           read_settings(path, o);
           o.settings_file = path;
         },
         "a .json file of settings, as --save-settings writes it; options given beside it override "
         "it")
      ->type_name("FILE");
}

void add_limits(CLI::App* app, LimitOptions& o) {
  add_size(app, "--memory-limit", o.memory_bytes,
           "turn away what needs more memory: bytes, or with K, M, G, T powers of 1024 of them "
           "[three quarters of what the machine, its container or the job of Slurm has]");
  add_size(app, "--texture-memory", o.texture_bytes,
           "hold textures that take more than this, decoded, in a temporary file ($TMPDIR, else "
           "/tmp), and about so much of it in memory; the picture is the same [all in memory]");
  add_number(app, "--load-timeout", o.load_timeout_s, kLeastLoadTimeout, kMostLoadTimeout,
             "give up loading and building after so many seconds [never]");
}

void add_machine_options(CLI::App* app, RenderOptions& o) {
  add_number(
      app, "--threads", o.threads, 1, kMostThreads,
      "worker threads [one for each processor that the process may use (taskset); in a job of "
      "Slurm no more than its processors]");
  add_limits(app, o.limits);
}

void add_heatmap_style(CLI::App* app, HeatmapStyle& style, CLI::Option* needed) {
  const auto read_colours = [&style](const std::string& name) {
    style.colours = parse_colour_map(name);
    return true;
  };
  const auto read_range = [&style](const std::string& text) {
    std::array<double, 2> v;
    if (!parse_numbers(text, ',', v) || !is_heatmap_range(v[0], v[1])) return false;
    style.range = ValueRange{v[0], v[1]};
    return true;
  };
  for (CLI::Option* option :
       {add_parsed(app, "--colors", "NAME",
                   table_help("colours of a heatmap [grey]", colour_map_table()), "", read_colours),
        add_parsed(app, "--range", "MIN,MAX",
                   "values at the ends of a heatmap's colours; times in seconds [0 to what the "
                   "greatest 2 % of the values above 0 exceed]",
                   "MIN,MAX with MIN less than MAX by a millionth at least, from -1e18 to 1e18",
                   read_range),
        app->add_flag("--log", style.logarithmic, "logarithmic scale for a heatmap"),
        app->add_flag("--plain", style.plain, "a heatmap without its legend")}) {
    if (needed) option->needs(needed);
  }
}

void add_heatmaps(CLI::App* app, RenderOptions& o) {
  CLI::Option* heatmap = add_text(app, "--heatmap", o.heatmaps, "FILE",
                                  "where the samples went, as a picture with legend: .png, .jpg; "
                                  ".exr: the numbers alone. May be given more than once");
  add_text(app, "--heatmap-of", o.heatmap_of, "NAME",
           table_help("what it shows, the n-th for the n-th [samples]", heatmap_quantity_table()))
      ->needs(heatmap);
  add_heatmap_style(app, o.heatmap_style, heatmap);
}

void add_grading(CLI::App* app, DisplaySettings& o) {
  app->add_option("--view", o.view, "OpenColorIO view [the display's default]");
  app->add_option("--look", o.look, "OpenColorIO look [none]");
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f, "stops, for .png and .jpg [0]");
}

void add_display_options(CLI::App* app, DisplaySettings& o) {
  add_text(app, "--display", o.display, "NAME", "OpenColorIO display [the config's default]");
  add_grading(app, o);
}

void add_outputs(CLI::App* app, RenderOptions& o, const char* output_help,
                 const char* report_help) {
  add_text(app, "-o,--output", o.outputs, "FILE", output_help);
  add_heatmaps(app, o);
  add_text(app, "--report", o.reports, "FILE", report_help);
  add_display_options(app, o.display);
}

}  // namespace emberline
