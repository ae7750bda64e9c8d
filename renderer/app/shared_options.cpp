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

using H = HelpSection;

}  // namespace

CLI::Option* describe(CLI::Option* option, const OptionText& text, const std::string& lines) {
  const std::string example = text.example.empty() ? "" : "\nExample: " + text.example;
  option->description(text.full + lines + example);
  option->option_text(text.brief);
  option->default_str(text.fallback);
  option->group(std::string(title_of(text.section)));
  return option;
}

void add_rules(CLI::Option* option, std::string_view rules) {
  std::string text = option->get_description();
  text.insert(std::min(text.find('\n'), text.size()), as_sentences(rules));
  option->description(text);
}

CLI::Option* add_parsed(CLI::App* app, const std::string& name, const std::string& type,
                        const OptionText& help, const std::string& what,
                        const std::function<bool(const std::string& text)>& read) {
  const auto check = [name, what, read](const std::string& text) {
    if (read(text)) return;
    throw CLI::ValidationError(name, fmt::format("'{}' is not {}", shortened(text), what));
  };
  return describe(app->add_option_function<std::string>(name, check)->type_name(type), help);
}

CLI::Option* add_text(CLI::App* app, const std::string& option, std::string& target,
                      const std::string& type, const OptionText& help) {
  return describe(app->add_option(option, target)->type_name(type), help);
}

CLI::Option* add_text(CLI::App* app, const std::string& option, std::optional<std::string>& target,
                      const std::string& type, const OptionText& help) {
  return describe(app->add_option(option, target)->type_name(type), help);
}

CLI::Option* add_text(CLI::App* app, const std::string& option, std::vector<std::string>& target,
                      const std::string& type, const OptionText& help) {
  return describe(app->add_option(option, target)->type_name(type)->allow_extra_args(false), help);
}

CLI::Option* add_argument(CLI::App* app, const std::string& name, std::string& target,
                          const std::string& help) {
  return app->add_option(name, target, help);
}

CLI::Option* add_flag(CLI::App* app, const std::string& option, bool& target,
                      const OptionText& help) {
  return describe(app->add_flag(option, target), help);
}

CLI::Option* add_checked_name(CLI::App* app, const std::string& option, std::string& target,
                              const std::function<void(const std::string& name)>& check,
                              const OptionText& help, const std::string& lines) {
  CLI::Option* added = app->add_option(option, target);
  added->type_name("NAME")->check([check](const std::string& name) {
    check(name);
    return std::string();
  });
  return describe(added, help, lines);
}

void add_size(CLI::App* app, const std::string& option, std::optional<uint64_t>& bytes,
              const OptionText& help) {
  add_parsed(app, option, "SIZE", help, "a size, such as 8G, 500MB or 4096",
             [&bytes](const std::string& text) {
               bytes = parse_size(text);
               return bytes.has_value();
             });
}

void add_setting(CLI::App* app, const Setting& setting, FrameSettings& settings) {
  const std::string option = "--" + setting.name;
  const RulesHelp& rules = rules_of(setting);
  OptionText help = setting.help;
  help.fallback = default_of(setting, settings);
  if (setting.type.empty()) {
    CLI::Option* flag = app->add_flag_function(
        option, [&](int64_t count) { setting.read(settings, count > 0 ? "yes" : "no"); });
    add_rules(describe(flag, help), rules.rules);
    return;
  }
  CLI::Option* added = app->add_option_function<std::string>(
      option, [&](const std::string& text) { setting.read(settings, text); });
  add_rules(describe(added, help, rules.values), rules.rules);
  added->type_name(setting.type);
  const bool nodes = setting.type.ends_with(",...");
  if (nodes || setting.type == "LIST") added->join(',');  // `--aov albedo --aov N` selects both
  if (setting.type == "LIST") {
    added->check([option](const std::string& list) {
      return list.empty() ? "needs a value, but the given one is empty: " + option + " LIST" : "";
    });
  }
}

void add_settings(CLI::App* app, FrameSettings& settings,
                  std::initializer_list<SettingGroup> groups,
                  std::initializer_list<std::string_view> excluded) {
  for (const Setting& setting : setting_table()) {
    const bool is_included = std::ranges::find(groups, setting.group) != groups.end() &&
                             std::ranges::find(excluded, setting.name) == excluded.end();
    if (is_included) add_setting(app, setting, settings);
  }
}

void add_settings_file(CLI::App* app, RenderOptions& o) {
  CLI::Option* added =
      app->add_option_function<std::string>("--settings", [&o](const std::string& path) {
        if (path.empty()) return;  // reject_empty_values() reports it later
        read_settings(path, o);
        o.settings_file = path;
      });
  describe(added->type_name("FILE"),
           {.section = H::kGeneral,
            .full = "Read settings from this .json file, which `save-settings` writes. Options on "
                    "the command line override it.",
            .example = "--settings final.json"});
}

void add_limits(CLI::App* app, LimitOptions& o) {
  add_size(app, "--memory-limit", o.memory_bytes,
           {.section = H::kLimits,
            .brief = "fail rather than use more memory than this, such as 8G",
            .full = "Stop with an error rather than use more memory than this. SIZE is a number of "
                    "bytes, or has a unit: 8G and 8GiB are 8 times 1024^3 bytes, 8GB are 8 times "
                    "1000^3; also K, M and T.",
            .fallback = "three quarters of the memory of the machine, its container or the Slurm "
                        "job",
            .example = "--memory-limit 8G"});
  add_size(app, "--texture-memory", o.texture_bytes,
           {.section = H::kLimits,
            .full = "If the decoded textures take more than this, keep them in a temporary file "
                    "($TMPDIR, or else /tmp), and hold about this much of them in memory. This "
                    "does not change the picture.",
            .fallback = "all textures are in memory",
            .example = "--texture-memory 2G"});
  add_number(app, "--load-timeout", o.load_timeout_s, kMinLoadTimeout, kMaxLoadTimeout,
             {.section = H::kLimits,
              .full = "Give up if loading and building the scene takes longer than this many "
                      "seconds.",
              .fallback = "never"});
}

void add_checkpoint_interval(CLI::App* app, RenderOptions& o) {
  add_number(
      app, "--checkpoint-interval", o.checkpoint_interval_s, 0.1, 1e9,
      {.section = H::kOutput,
       .full =
           "Set the number of seconds between checkpoints. The signal SIGUSR1 writes one at once.",
       .fallback = "300"});
}

void add_threads(CLI::App* app, int& threads) {
  add_number(app, "--threads", threads, 1, kMaxThreads,
             {.section = H::kLimits,
              .brief = "worker threads [one per processor]",
              .full = "Use this many worker threads.",
              .fallback = "one for each processor that the process may use (taskset); in a Slurm "
                          "job, at most the job's processors",
              .example = "--threads 4"});
}

void add_machine_options(CLI::App* app, RenderOptions& o) {
  add_threads(app, o.threads);
  add_limits(app, o.limits);
}

void add_heatmap_style(CLI::App* app, HeatmapStyle& style, CLI::Option* required_option) {
  const auto read_colours = [&style](const std::string& name) {
    style.colours = parse_colour_map(name);
    return true;
  };
  const auto read_range = [&style](const std::string& text) {
    std::array<double, 2> v;
    if (!parse_numbers(text, ',', v) || !is_valid_heatmap_range(v[0], v[1])) return false;
    style.range = ValueRange{v[0], v[1]};
    return true;
  };
  // --help shows these options only for `heatmap`, which has few options.
  const auto brief = [&](const char* text) { return required_option ? "" : text; };
  const OptionText colours = {.section = H::kOutput,
                              .brief = brief("colours: grey, viridis, inferno, magma or turbo"),
                              .full = "Choose the colours of heatmaps.",
                              .fallback = "grey",
                              .example = "--heatmap samples.png --colors viridis"};
  const OptionText range = {
      .section = H::kOutput,
      .brief = brief("values of the first and the last colour"),
      .full =
          "Set the values that heatmaps show in their first and last colour. Times are in seconds.",
      .fallback = "0 to the 98th percentile of the values above 0",
      .example = "--heatmap samples.png --range 0,256"};
  for (CLI::Option* option :
       {describe(add_parsed(app, "--colors", "NAME", colours, "", read_colours), colours,
                 table_lines(colour_map_table())),
        add_parsed(
            app, "--range", "MIN,MAX", range,
            "MIN,MAX from -1e18 to 1e18; MAX - MIN must be at least a millionth of the larger "
            "magnitude",
            read_range),
        add_flag(app, "--log", style.logarithmic,
                 {.section = H::kOutput,
                 .brief = brief("use a logarithmic scale"),
                 .full = "Use a logarithmic scale for heatmaps."}),
        add_flag(app, "--plain", style.plain,
                 {.section = H::kOutput,
                 .brief = brief("leave out the legend"),
                 .full = "Leave out the legend of heatmaps."})}) {
    if (required_option) option->needs(required_option);
  }
}

void add_heatmaps(CLI::App* app, RenderOptions& o) {
  CLI::Option* heatmap =
      add_text(app, "--heatmap", o.heatmaps, "FILE",
               {.section = H::kOutput,
                .brief = "picture of where the samples went: .png, .jpg or .exr",
                .full = "Write a picture of where the samples went. .png and .jpg files have a "
                        "legend; an .exr file has only the values. May be given more than once.",
                .example = "--heatmap samples.png"});
  CLI::Option* quantity = app->add_option("--heatmap-of", o.heatmap_of)->type_name("NAME");
  describe(quantity->allow_extra_args(false)->needs(heatmap),
           {.section = H::kOutput,
            .full = "Choose what the heatmap shows. If there are several heatmaps, give this "
                    "option once for each, in the same order.",
            .fallback = "samples",
            .example = "--heatmap error.png --heatmap-of error"},
           table_lines(heatmap_quantity_table()));
  add_heatmap_style(app, o.heatmap_style, heatmap);
}

void add_grading(CLI::App* app, DisplaySettings& o) {
  describe(app->add_option("--view", o.view),
           {.section = H::kOutput,
            .full = "Show the picture through this OpenColorIO view. .exr files stay linear.",
            .fallback = "the display's default",
            .example = "--view ACES"});
  describe(app->add_option("--look", o.look),
           {.section = H::kOutput,
            .full = "Apply this OpenColorIO look to the displayed picture.",
            .fallback = "none"});
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f,
             {.section = H::kOutput,
              .brief = "brighten .png and .jpg files by this many stops",
              .full = "Brighten the displayed picture by this many stops. .exr files do not "
                      "change.",
              .fallback = "0",
              .example = "--exposure -1.5"});
}

void add_display_options(CLI::App* app, DisplaySettings& o) {
  add_text(app, "--display", o.display, "NAME",
           {.section = H::kOutput,
            .full = "Convert the picture for this OpenColorIO display.",
            .fallback = "the config's default"});
  add_grading(app, o);
}

void add_outputs(CLI::App* app, RenderOptions& o, const OptionText& output,
                 const OptionText& report) {
  add_text(app, "-o,--output", o.outputs, "FILE", output);
  add_heatmaps(app, o);
  add_text(app, "--report", o.reports, "FILE", report);
  add_display_options(app, o.display);
}

}  // namespace emberline
