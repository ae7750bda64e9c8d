// Options of the commands that work on existing files, and of `farm`, `study` and `help`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <initializer_list>

#include "renderer/app/command_options.h"
#include "renderer/app/frame_animation.h"
#include "renderer/app/frame_range.h"
#include "renderer/app/shared_options.h"
#include "renderer/engine/setting_table.h"
#include "renderer/statistics/study/options.h"

namespace emberline {
namespace {

using enum SettingGroup;
using H = HelpSection;

void add_json(CLI::App* app, bool& json) {
  add_flag(app, "--json", json,
           {.section = H::kOutput,
            .brief = "print JSON for programs",
            .full = "Print JSON, for programs."});
}

CLI::Option* add_scene(CLI::App* app, std::string& scene) {
  return add_argument(app, "scene", scene, "The scene: a .gltf or .glb file.");
}

// Adds --frames for a command that can `verb` a sequence.
void add_frames(CLI::App* app, std::vector<int>& frames, const char* verb, const char* more) {
  CLI::Option* option = app->add_option_function<std::string>(
      "--frames", [&frames](const std::string& text) { frames = parse_frames(text); });
  describe(option->type_name("LIST"), {.section = H::kOutput,
                                       .brief = "frames of the sequence, such as 1-24",
                                       .full = fmt::format("{} only these frames.{}", verb, more),
                                       .fallback = "all frames that exist",
                                       .example = "shot.####.exr --frames 10-20 -o new.####.png"});
}

// Adds the options for the jobs of `emberline farm`.
void add_job_options(CLI::App* app, FarmOptions& o) {
  add_number(app, "--parts", o.parts, 1u, 4096u,
             {.section = H::kJobs,
              .brief = "number of jobs that share the frame",
              .full = "Split the frame into this many parts, each a job.",
              .example = "--parts 16"});
  add_text(app, "--frames", o.frames, "LIST",
           {.section = H::kJobs,
            .full = "Accepts only 0, because `emberline farm` renders a single frame. For several "
                    "frames, submit an `emberline render` with `frames` for each.",
            .fallback = "0"})
      ->check([](const std::string& list) {
        return list == "0"
                   ? ""
                   : "--frames: '" + list +
                         "': the only frame is 0, since farm renders one frame in parts; for "
                         "several frames, submit one `emberline render --frames` job for each";
      });
  add_text(app, "--partition", o.request.partition, "LIST",
           {.section = H::kJobs,
            .brief = "Slurm partition of the jobs",
            .full = "Submit the jobs to this Slurm partition, or to one of a comma-separated list.",
            .fallback = "Slurm's default"});
  add_number(app, "--cpus", o.request.cpus, 1, 4096,
             {.section = H::kJobs,
              .brief = "processors of each job",
              .full = "Ask for this many processors for each job.",
              .fallback = "a whole node"});
  add_size(app, "--memory", o.request.memory_bytes,
           {.section = H::kJobs,
            .brief = "memory of each job, such as 8G",
            .full = "Ask for this much memory for each job. SIZE is a number of bytes, or has a "
                    "unit: 8G and 8GiB are 8 times 1024^3 bytes, 8GB are 8 times 1000^3; also K, M "
                    "and T.",
            .fallback = "the partition's default",
            .example = "--memory 16G"});
  add_number(
      app, "--minutes", o.request.minutes, 2, 10000000,
      {.section = H::kJobs,
       .brief = "time limit of each job in minutes",
       .full = "Limit the time of each job to this many minutes. One minute before the limit, "
               "a part or the plan saves its work, and `emberline farm retry` continues it.",
       .fallback = "the partition's default"});
  add_flag(
      app, "--print", o.print,
      {.section = H::kJobs,
       .brief = "print the commands for another queue instead of submitting",
       .full = "Submit nothing. For another queue, print the command that renders a part, with the "
               "placeholders {part} and {parts}, and the command that merges the parts."});
  add_flag(app, "--stage", o.stage,
           {.section = H::kJobs,
            .brief = "copy the scene to each node's disk first",
            .full = "Copy the scene to each node's $TMPDIR first, once per node."});
}

void add_farm_verb(CLI::App* app, FarmOptions& o, FarmVerb verb, const char* name,
                   const char* help) {
  CLI::App* sub = app->add_subcommand(name, help);
  add_argument(sub, "output", o.output, "The output that was given to `emberline farm`.")
      ->required();
  sub->parse_complete_callback([&o, verb] { o.verb = verb; });
  if (verb == FarmVerb::kStatus) add_json(sub, o.json);
}

// Shows the options of these sections only in --help-all.
void hide_from_help(CLI::App* app, std::initializer_list<HelpSection> sections) {
  for (CLI::Option* option : app->get_options()) {
    for (const HelpSection section : sections) {
      if (option->get_group() == title_of(section)) option->option_text("");
    }
  }
}

OptionText study_option(const char* brief, const char* full, const std::string& fallback,
                        const char* example = "") {
  return {
      .section = H::kStudy, .brief = brief, .full = full, .fallback = fallback, .example = example};
}

void add_study_methods(CLI::App* app, StudyOptions& o) {
  const auto add = [app](const char* name, std::string& target, const OptionText& help,
                         const char* setting) {
    CLI::Option* list = app->add_option(name, target)->type_name("LIST");
    describe(list, help, table_lines(find_setting(setting)->choices));
  };
  add("--drivers", o.drivers,
      study_option("drivers to compare", "Compare these drivers, a comma-separated list.",
                   "bucket,bisection,adaptive"),
      "driver");
  add("--estimators", o.estimators,
      study_option(
          "error estimators of the adaptive driver",
          "Compare these estimators of the adaptive driver, a comma-separated list of "
          "ESTIMATOR[/ALLOCATION][/unbiased or /planned]. A planned frame gets the sample "
          "counts that `emberline plan` would write; its samples and time include the pilot.",
          o.estimators, "--estimators nested,kajiya"),
      "estimator");
  CLI::Option* samplers = app->add_option("--samplers", o.samplers)->type_name("LIST");
  describe(samplers,
           study_option("samplers to compare", "Compare these samplers, a comma-separated list.",
                        "sobol; all with --convergence"),
           table_lines(find_setting("sampler")->choices));
  add_text(
      app, "--spp", o.spp, "LIST",
      study_option("sample counts to measure",
                   "Measure at these samples per pixel (on average), a comma-separated list in "
                   "ascending order.",
                   "1,2,4,8,16,32,64", "--spp 4,16,64"));
  add_text(
      app, "--seconds", o.seconds, "LIST",
      study_option(
          "rendering times to measure at, not sample counts",
          "Measure after these rendering times, in seconds, instead of at sample counts. LIST is a "
          "comma-separated list in ascending order. If a method renders a separate frame for "
          "each time, `time-budget` keeps the time. Planned frames, and samplers that must know "
          "the number of samples in advance, get as many as a measurement of the speed suggests.",
          "", "--seconds 1,2,4,8"));
  add_number(app, "--seeds", o.seeds, 1u, kMaxStudySeeds,
             study_option("runs of each method, with different seeds",
                          "Run each method this many times, with consecutive seeds that start at "
                          "`seed`. With --convergence, measure this many pixels.",
                          "5; 2000 with --convergence"));
  add_text(app, "--baseline", o.baseline, "NAME",
           study_option("method that the others are compared with",
                        "Compare the other methods with this one.", "the first method"));
}

void add_study_choices(CLI::App* app, StudyOptions& o) {
  add_scene(app, o.frame.scene);
  add_text(app, "-o,--output", o.folder, "DIR",
           {.section = H::kStudy,
            .brief = "folder for the results",
            .full = "Write the results to this folder. It is created if it does not exist.",
            .example = "-o study"});
  add_study_methods(app, o);
  CLI::Option* frames = app->add_option_function<std::string>(
      "--frames", [&o](const std::string& text) { o.frame.frames = parse_frames(text); });
  describe(frames->type_name("LIST"),
           {.section = H::kStudy,
            .brief = "frames to study, such as 1-24",
            .full = "Study these frames, each in a folder of its own, and also write their errors "
                    "and flicker together (range.html, range.csv, range.json). A `turntable` of N "
                    "frames does the same. #### in --reference becomes the frame's number.",
            .example = "--frames 1-24"});
  add_flag(app, "--denoise", o.denoise,
           {.section = H::kStudy,
            .brief = "also measure each method with its frames denoised",
            .full = "Measure each method a second time as NAME+denoise, with denoised frames and "
                    "including the denoiser's time. Implies --separate."});
  add_flag(app, "--separate", o.separate,
           {.section = H::kStudy,
            .full = "Render a separate frame for every budget, even where one frame could be "
                    "measured at several budgets."});
  CLI::Option* reference =
      add_text(app, "--reference", o.reference, "FILE",
               {.section = H::kStudy,
                .brief = "reference picture to measure errors against",
                .full = "Measure errors against this picture.",
                .fallback = "a reference is rendered, in two halves, so that its own noise can be "
                            "subtracted"});
  add_number(app, "--reference-spp", o.reference_spp, 2u, kMaxSamples,
             {.section = H::kStudy,
              .full = "Render the reference with this many samples per pixel.",
              .fallback = "64 times the largest budget"})
      ->excludes(reference);
  add_text(app, "--cache", o.cache, "DIR",
           {.section = H::kStudy,
            .full = "Keep rendered references in this folder.",
            .fallback = "`reference` in the results folder"})
      ->excludes(reference);
  add_flag(app, "--restart", o.restart,
           {.section = H::kStudy, .full = "Discard the runs that the folder already has."});
  add_flag(app, "--convergence", o.convergence,
           {.section = H::kStudy,
            .brief = "measure the samplers on known integrals, without a scene",
            .full = "Measure variance against the number of samples on integrals with known "
                    "values. This needs no scene."});
}

}  // namespace

void add_info_options(CLI::App* app, InfoOptions& o) {
  CLI::Option* scene =
      add_argument(app, "scene", o.scene, "The scene: a .gltf or .glb file; or a frame: .exr.");
  CLI::Option* channels =
      add_flag(app, "--channels", o.channels,
               {.section = H::kOutput,
                .brief = "list the channels that pictures can have, without a scene",
                .full = "List the channels that pictures can have. This needs no scene."})
          ->excludes(scene);
  add_flag(app, "--edits", o.edits,
           {.section = H::kOutput,
            .brief = "print an edits file to start from",
            .full = "Print an edits file for `emberline render --edits` with the present values of "
                    "every light, every material and the environment. It changes nothing until you "
                    "edit it. Give `env` or `sun` as for the render."})
      ->excludes(channels);
  add_json(app, o.json);
  add_settings(app, o.settings, {kLight, kLoading}, {"working-space", "backfaces"});
  add_limits(app, o.limits);
  app->footer(
      "emberline info scene.glb\n"
      "emberline info scene.glb --edits > look.json\n"
      "emberline info frame.exr\n"
      "emberline info --channels");
}

void add_heatmap_options(CLI::App* app, HeatmapOptions& o) {
  o.quantity = heatmap_quantity_table().front().name;
  add_argument(app, "image", o.image, "An .exr file that `emberline render` wrote.")->required();
  add_text(app, "-o,--output", o.output, "FILE",
           {.section = H::kOutput,
            .brief = "heatmap to write: .png, .jpg or .exr",
            .full = "Write the heatmap to this file. .png and .jpg files have a legend; an .exr "
                    "file has only the values."})
      ->required();
  describe(app->add_option("--of", o.quantity)->type_name("NAME"),
           {.section = H::kOutput,
            .brief = "what to show: samples, error, stop, time, ...",
            .full = "Choose what the heatmap shows.",
            .fallback = "samples",
            .example = "--of error"},
           table_lines(heatmap_quantity_table()));
  add_text(app, "--against", o.against, "FILE",
           {.section = H::kOutput,
            .brief = "show the time saved over this frame of the same view",
            .full = "Show how many times less time the frame needs for an equal error than this "
                    "one of the same view: squared error times time of FILE over that of IMAGE, as "
                    "sums over 5x5 pixels. Render both with `streams` 2 and `aov` variance,time: "
                    "with one stream, the errors of uniform frames are overestimated.",
            .example = "--against uniform.exr --log"})
      ->excludes("--of");
  add_heatmap_style(app, o.style, nullptr);
  add_limits(app, o.limits);
  app->footer("emberline heatmap frame.exr -o error.png --of error --colors viridis");
}

void add_show_options(CLI::App* app, ShowOptions& o) {
  add_argument(app, "frame", o.image,
               "The frame: an .exr file from any program. A run of # is the number of a frame: "
               "shot.####.exr stands for all such files.")
      ->required();
  add_text(
      app, "-o,--output", o.outputs, "FILE",
      {.section = H::kOutput,
       .brief = "picture to write: .png, .jpg, .exr, or .gif for a sequence",
       .full = "Write the picture to this file. .png and .jpg files are converted for display; an "
               ".exr file has only this layer, as linear R, G and B. A .gif file is an animation "
               "of a sequence, at most 640 pixels wide and high; the names of other files need a "
               "run of # if there are several frames. May be given more than once."})
      ->required();
  add_frames(app, o.frames, "Show", "");
  add_number(app, "--fps", o.fps, double(kMinAnimationFps), double(kMaxAnimationFps),
             {.section = H::kOutput,
              .brief = "frames per second of a .gif [24]",
              .full = "Play the .gif with this many frames per second. The time of a frame is "
                      "rounded to hundredths of a second.",
              .fallback = "24",
              .example = "shot.####.exr -o shot.gif --fps 12"});
  add_text(app, "--layer", o.layer, "NAME",
           {.section = H::kOutput,
            .brief = "layer to show, such as denoised, albedo or Z",
            .full = "Show this layer or channel. `emberline info` lists them. Coordinates become "
                    "red, green and blue. A single channel becomes grey; unless all its values are "
                    "from 0 to 1, the least is black and the greatest is white.",
            .fallback = "R, G and B; or the only layer that has them",
            .example = "--layer albedo"});
  add_display_options(app, o.display);
  app->get_option("--view")->option_text("OpenColorIO view, such as ACES");
  add_limits(app, o.limits);
  app->footer(
      "emberline show frame.exr -o frame.png --view ACES --exposure -1\n"
      "emberline show frame.exr -o albedo.png --layer albedo\n"
      "emberline show shot.####.exr -o shot.gif");
}

void add_explain_options(CLI::App* app, ExplainOptions& o) {
  add_argument(app, "image", o.image, "An .exr file that `emberline render` wrote.")->required();
  add_argument(app, "pixel", o.pixel,
               "The pixel: X,Y, or worst for the one with the largest error (needs --aov "
               "variance). The default is worst.");
  add_limits(app, o.limits);
  app->footer(
      "emberline explain frame.exr 412,93\n"
      "emberline explain frame.exr worst");
}

void add_compare_options(CLI::App* app, CompareOptions& o) {
  add_argument(app, "image", o.image,
               "The picture to measure, or a sequence of pictures, such as shot.####.exr.")
      ->required();
  add_argument(app, "reference", o.reference, "The picture or the sequence to compare it with.")
      ->required();
  add_json(app, o.json);
  add_text(
      app, "-o,--difference", o.difference, "FILE",
      {.section = H::kOutput,
       .brief = "picture of the difference: FLIP as .png, signed as .exr",
       .full = "Write a picture of the difference: a .png file shows FLIP in false colour, an "
               ".exr file has the signed difference. For a sequence, the name needs ####, too."});
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f,
             {.section = H::kOutput,
              .brief = "brighten both pictures by this many stops for FLIP, SSIM, PSNR",
              .full = "Brighten both pictures by this many stops for FLIP, SSIM and PSNR.",
              .fallback = "0"});
  add_text(app, "--layer", o.layer, "NAME",
           {.section = H::kOutput,
            .brief = "layer to measure, such as denoised or albedo",
            .full = "Measure this layer or channel, which must have one or three values per pixel, "
                    "against the reference's layer of the same name. If the reference lacks it, a "
                    "denoised layer is compared with the raw layer or picture, and other layers "
                    "with the picture of a reference that has no layers.",
            .fallback = "R, G and B; or the only layer that has them",
            .example = "--layer denoised"});
  add_text(app, "--chart", o.chart, "FILE",
           {.section = H::kOutput,
            .brief = "chart of a sequence's errors, as .svg",
            .full = "Draw the error of each frame of a sequence, and its change from frame to "
                    "frame, as an .svg file."});
  add_limits(app, o.limits);
  app->footer("emberline compare frame.exr reference.exr -o flip.png");
}

void add_denoise_options(CLI::App* app, DenoiseOptions& o) {
  add_argument(app, "frame", o.image,
               "An .exr file that `emberline render` wrote with --aov denoising. A run of # is "
               "the number of a frame: shot.####.exr stands for all such files.")
      ->required();
  add_text(app, "-o,--output", o.outputs, "FILE",
           {.section = H::kOutput,
            .brief = "picture to write: .exr, .png or .jpg",
            .full = "Write the result to this file. An .exr file has all channels of the frame, "
                    "denoised.{R,G,B} and denoised.error; .png and .jpg files show the denoised "
                    "picture. May be given more than once. Its name needs a run of # if there are "
                    "several frames."})
      ->required();
  add_number(app, "--across", o.across, 0, kMaxAcross,
             {.section = H::kOutput,
              .brief = "use the samples of the N frames before and after each frame",
              .full = std::string(kAcrossText) +
                      " This needs a sequence of frames with --aov denoising,velocity, or better "
                      "denoising,specular_velocity.",
              .example = "shot.####.exr --across 2 -o clean.####.exr"});
  add_frames(app, o.frames, "Denoise", " The other files still serve as neighbours.");
  add_display_options(app, o.display);
  add_threads(app, o.threads);
  add_limits(app, o.limits);
  app->footer(
      "emberline render scene.glb -o frame.exr --aov denoising\n"
      "emberline denoise frame.exr -o clean.png\n"
      "emberline denoise shot.####.exr --across 2 -o clean.####.exr");
}

void add_extend_options(CLI::App* app, ExtendOptions& o) {
  add_argument(
      app, "frame", o.frame,
      "A picture that was rendered with --resumable, or its checkpoint. The new limits are "
      "totals: --spp 256 continues to 256 samples per pixel.")
      ->required();
  add_text(app, "--scene", o.scene, "FILE",
           {.section = H::kScene,
            .brief = "where the scene is now, if it was moved",
            .full = "Read the scene from this file.",
            .fallback = "the file that the frame was rendered from"});
  for (const char* name : {"spp", "noise-threshold", "max-spp", "time-limit"}) {
    add_setting(app, *find_setting(name), o.overrides);
  }
  add_outputs(app, o.overrides,
              {.section = H::kOutput,
               .brief = "picture to write: .exr, .png or .jpg",
               .full = "Write the picture to this file: .exr, .png or .jpg. May be given more than "
                       "once.",
               .fallback = "the frame's own file"},
              {.section = H::kOutput,
               .brief = "report of the render: .html or .json",
               .full = "Write a report of the render: .html or .json."});
  add_checkpoint_interval(app, o.overrides);
  add_machine_options(app, o.overrides);
  app->footer(
      "emberline render scene.glb -o frame.exr --spp 64 --resumable\n"
      "emberline extend frame.exr --spp 256");
}

void add_merge_options(CLI::App* app, MergeOptions& o) {
  app->add_option("parts", o.parts,
                  "Checkpoints that `emberline render` kept with --part, --sample-range or "
                  "--resumable. Frames that differ in --seed are averaged.")
      ->required();
  add_outputs(app, o.frame,
              {.section = H::kOutput,
               .brief = "picture to write: .exr, .png or .jpg",
               .full = "Write the merged picture to this file: .exr, .png or .jpg. May be given "
                       "more than once."},
              {.section = H::kOutput,
               .brief = "report of the merged frame: .json",
               .full = "Write a report of the merged frame as JSON."});
  add_flag(app, "--allow-holes", o.allow_holes,
           {.section = H::kParts,
            .brief = "write a frame even if parts are missing; their pixels are black",
            .full = "Write the frame even if parts are missing. Their pixels are black, and their "
                    "`aov` stop is 0."});
  add_flag(app, "--resumable", o.frame.resumable,
           {.section = H::kOutput,
            .brief = "keep a checkpoint of the merged frame, for `emberline extend`",
            .full = "Keep a checkpoint of the merged frame beside the first output "
                    "(FILE.checkpoint), so that `emberline extend` can add samples. This needs all "
                    "parts, rendered with driver bucket and the same seed."});
  add_flag(app, "--strict", o.strict,
           {.section = H::kParts,
            .brief = "refuse parts from different kinds of machine",
            .full = "Refuse parts that come from different kinds of machine."});
  add_machine_options(app, o.frame);
  app->footer(
      "emberline render scene.glb -o frame.exr --part 1/2\n"
      "emberline render scene.glb -o frame.exr --part 2/2\n"
      "emberline merge frame.exr.part-*.checkpoint -o frame.exr");
}

void add_farm_options(CLI::App* app, FarmOptions& o) {
  // The scene is not required, because the subcommands take none.
  add_scene(app, o.frame.scene);
  add_settings_file(app, o.frame);
  add_outputs(app, o.frame,
              {.section = H::kOutput,
               .brief = "picture to write: .exr, .png or .jpg",
               .full = "Write the picture to this file: .exr, .png or .jpg. The folder FILE.farm "
                       "beside the first one holds the jobs. #### in a name becomes the frame's "
                       "number. May be given more than once."},
              {.section = H::kOutput,
               .brief = "report of the merged frame: .json",
               .full = "Write a report of the merged frame as JSON."});
  add_job_options(app, o);
  add_settings(app, o.frame,
               {kEdits, kChannels, kCounts, kSample, kSeed, kSchedule, kView, kLight, kLoading},
               {"time-limit", "time-budget"});
  hide_from_help(app, {H::kView, H::kLight, H::kScene});
  app->require_subcommand(0, 1);
  add_farm_verb(app, o, FarmVerb::kStatus, "status",
                "Show the progress of all parts, and any failures.");
  add_farm_verb(app, o, FarmVerb::kCancel, "cancel", "Cancel the jobs; finished work is kept.");
  add_farm_verb(app, o, FarmVerb::kRetry, "retry", "Submit the missing parts and the merge again.");
  app->footer(
      "emberline farm scene.glb -o frame.exr --parts 16 --minutes 60\n"
      "emberline farm status frame.exr\n"
      "emberline farm retry frame.exr");
}

void add_study_options(CLI::App* app, StudyOptions& o) {
  o.frame.width = 320;
  o.frame.height = 180;
  add_study_choices(app, o);
  add_settings(app, o.frame, kStudySettings);
  add_machine_options(app, o.frame);
  app->footer("emberline study scene.glb -o study --drivers bucket,adaptive --spp 4,16,64");
}

void add_help_options(CLI::App* app, HelpOptions& o) {
  app->add_option("command", o.words, "A command, and one of its options with or without dashes.");
  app->allow_extras();  // accepts an option with its dashes
  app->footer(
      "emberline help render\n"
      "emberline help render noise-threshold");
}

}  // namespace emberline
