// The options of each subcommand: names, ranges, defaults and help.
#pragma once

#include "renderer/app/commands.h"
#include "renderer/window/view_command.h"

namespace CLI {
class App;
}

namespace emberline {

// Each function sets the defaults of `options` and adds the command-line options that fill it in.
// `options` must live until the arguments are parsed.
void add_render_options(CLI::App* app, RenderOptions& options);
void add_view_options(CLI::App* app, ViewOptions& options);
void add_session_options(CLI::App* app, SessionOptions& options);
void add_info_options(CLI::App* app, InfoOptions& options);
void add_heatmap_options(CLI::App* app, HeatmapOptions& options);
void add_show_options(CLI::App* app, ShowOptions& options);
void add_explain_options(CLI::App* app, ExplainOptions& options);
void add_compare_options(CLI::App* app, CompareOptions& options);
void add_denoise_options(CLI::App* app, DenoiseOptions& options);
void add_merge_options(CLI::App* app, MergeOptions& options);
void add_plan_options(CLI::App* app, PlanOptions& options);
void add_extend_options(CLI::App* app, ExtendOptions& options);
void add_farm_options(CLI::App* app, FarmOptions& options);
void add_study_options(CLI::App* app, StudyOptions& options);
void add_help_options(CLI::App* app, HelpOptions& options);

}  // namespace emberline
