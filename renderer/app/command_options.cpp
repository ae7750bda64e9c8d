#include "renderer/app/command_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "renderer/app/frame_range.h"
#include "renderer/app/shared_options.h"
#include "renderer/core/option_values.h"
#include "renderer/engine/run_limits.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/option_rules.h"
#include "renderer/output/snapshots.h"
#include "renderer/session/overlay_picture.h"

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

void add_scene(CLI::App* app, std::string& scene) {
  add_argument(app, "scene", scene, "The scene: a .gltf or .glb file.");
}

void add_snapshots(CLI::App* app, RenderOptions& o) {
  CLI::Option* snapshots = add_text(
      app, "--snapshots", o.snapshots, "DIR",
      {.section = H::kInspection,
       .full = "Keep the picture at several moments of the render in this folder, and all of them "
               "as refinement.gif. Each snapshot takes 16 bytes of memory per pixel until the "
               "frame is done.",
       .example = "--driver bisection --snapshots shots"});
  add_text(app, "--snapshot-at", o.snapshot_at, "LIST",
           {.section = H::kInspection,
            .full = "Take snapshots at these moments, a comma-separated list: 'first' is the first "
                    "picture, N% is when that share of the pixels has a sample, Ns is a time of "
                    "rendering in seconds, and Nspp is an average of samples per pixel.",
            .fallback = std::string(kDefaultSnapshotMoments),
            .example = "--snapshots shots --snapshot-at first,10s,60s"})
      ->needs(snapshots);
  add_name(
      app, "--snapshot-format", o.snapshot_format, "format",
      {.section = H::kInspection, .full = "Choose the format of snapshots.", .fallback = "png"},
      snapshot_format_table())
      ->needs(snapshots);
  add_text(app, "--reference", o.reference, "FILE",
           {.section = H::kInspection,
            .full = "Measure the error of each snapshot against this picture, and put it into the "
                    "report."})
      ->needs(snapshots);
}

void add_display(CLI::App* app, RenderOptions& o) {
  CLI::Option* added = app->add_option_function<std::vector<std::string>>(
      "--display", [&o](const std::vector<std::string>& values) {
        for (const std::string& value : values) {
          if (is_tev_url(value)) {
            o.viewer = parse_tev_url(value);
          } else {
            o.display.display = value;
          }
        }
      });
  describe(added->type_name("NAME|URL")->allow_extra_args(false),
           {.section = H::kOutput,
            .full = fmt::format("Show the picture for this OpenColorIO display. tev://HOST:PORT "
                                "shows the picture in the viewer tev while it renders instead; "
                                "the port is {} unless it is given. Both may be given, once each.",
                                TevAddress::kDefaultPort),
            .fallback = "the config's default",
            .example = "--display tev://localhost"});
}

void add_checkpoint_interval(CLI::App* app, RenderOptions& o) {
  add_number(app, "--checkpoint-interval", o.checkpoint_interval_s, 0.1, 1e9,
             {.section = H::kOutput,
              .full = "Write a checkpoint after this many seconds, again and again. The signal "
                      "SIGUSR1 writes one at once.",
              .fallback = "300"});
}

void add_checkpoint(CLI::App* app, RenderOptions& o) {
  add_text(app, "--checkpoint", o.checkpoint, "FILE",
           {.section = H::kOutput,
            .full = "Save the state of the frame in this file while it renders, so that `resume` "
                    "can continue it. The file is removed when the frame is done. A file that is "
                    "not a checkpoint is never replaced.",
            .example = "--checkpoint frame.checkpoint --resume"});
  add_flag(app, "--resumable", o.resumable,
           {.section = H::kOutput,
            .brief = "keep a checkpoint, for --resume and `emberline extend`",
            .full = "Save a checkpoint beside the first output (FILE.checkpoint), or where "
                    "`checkpoint` says. It stays when the frame is done, so that `emberline "
                    "extend` can add samples."});
  add_flag(app, "--resume", o.resume,
           {.section = H::kOutput,
            .brief = "continue an interrupted frame from its checkpoint",
            .full = "Continue from the checkpoint. The picture has the same bits as that of a "
                    "render without interruption. Without a checkpoint the frame starts over.",
            .example = "--resumable --resume"});
  add_checkpoint_interval(app, o);
  add_text(app, "--progress-file", o.progress_file, "FILE",
           {.section = H::kOutput,
            .full = "Write the progress of the frame to this .json file every two seconds."});
}

void add_range_options(CLI::App* app, RenderOptions& o) {
  CLI::Option* frames = app->add_option_function<std::string>(
      "--frames", [&o](const std::string& text) { o.frames = parse_frames(text); });
  describe(frames->type_name("LIST"),
           {.section = H::kOutput,
            .brief = "frames to render, such as 1-24; #### in a name is the number",
            .full = "Render these frames one after another: N, A-B, A-BxSTEP, or a comma-separated "
                    "list of them. #### in the names of outputs becomes the frame's number. Frame "
                    "N shows the scene at N / `fps` seconds.",
            .example = "--frames 1-24 -o shot.####.exr"});
  add_flag(
      app, "--skip-existing", o.skip_existing,
      {.section = H::kOutput, .full = "Skip frames whose outputs all exist and are complete."});
  add_flag(app, "--stop-on-error", o.stop_on_error,
           {.section = H::kOutput,
            .full = "Stop at the first frame that fails. Otherwise the other frames are still "
                    "rendered."});
  add_text(app, "--range-report", o.range_report, "FILE",
           {.section = H::kOutput,
            .full = "Write the result of each frame to this file as JSON. `report` describes a "
                    "single frame."});
}

void add_result_options(CLI::App* app, RenderOptions& o) {
  add_text(app, "-o,--output", o.outputs, "FILE",
           {.section = H::kOutput,
            .brief = "picture to write: .exr, .png or .jpg",
            .full = "Write the picture to this file. An .exr file has all channels in linear "
                    "floats and is written while the frame renders. .png, .jpg files are converted "
                    "for display by OpenColorIO and stay in memory until the frame is done. May be "
                    "given more than once.",
            .example = "-o frame.exr -o frame.png"});
  add_heatmaps(app, o);
  add_text(app, "--report", o.reports, "FILE",
           {.section = H::kOutput,
            .brief = "report of the render: .html or .json",
            .full = "Write a report of the render. An .html file is a page with pictures and "
                    "charts; .json or any other name gives JSON. May be given more than once.",
            .example = "--report frame.html"});
  add_snapshots(app, o);
  add_checkpoint(app, o);
  add_text(app, "--save-settings", o.save_settings, "FILE",
           {.section = H::kGeneral,
            .full = "Write the settings that differ from the defaults to this .json file, for "
                    "`settings`."});
  add_text(app, "--replay", o.replay, "X,Y,SAMPLE",
           {.section = H::kInspection,
            .full = "Compute only this sample of a pixel, and print it.",
            .example = "--replay 100,50,7"});
  add_parsed(app, "--explain", "X,Y",
             {.section = H::kInspection,
              .full = "After the render, print why this pixel got as many samples as it did.",
              .example = "--driver adaptive --explain 100,50"},
             "X,Y in whole pixels of the frame", [&o](const std::string& text) {
               std::array<int, 2> v;
               if (!parse_numbers(text, ',', v) || v[0] < 0 || v[1] < 0) return false;
               o.explained = Vec2i(v[0], v[1]);
               return true;
             });
  add_text(app, "--tree", o.trees, "FILE",
           {.section = H::kInspection,
            .full = "Write the refinement tree of the adaptive driver: .png, .jpg files show its "
                    "leaves over the picture, and a .json file has its data. May be given more "
                    "than once.",
            .example = "--driver adaptive --tree tree.png"});
  add_display(app, o);
  add_grading(app, o.display);
}

const SettingChoice kPictureFormats[] = {
    {"linear", "four floats per pixel, in linear Rec. 709"},
    {"display", "four bytes per pixel, converted for display by OpenColorIO"}};

// Frame options that the window and a session share.
void add_live_options(CLI::App* app, RenderOptions& o,
                      std::initializer_list<std::string_view> left_out) {
  std::vector<SettingChoice> drivers = find_setting("driver")->choices;
  drivers.insert(drivers.begin(), {kLiveDriver,
                                   "bisection until every pixel has a sample, then adaptive; takes "
                                   "the settings of adaptive"});
  OptionText driver = find_setting("driver")->help;
  driver.fallback = kLiveDriver;
  driver.brief = "rendering order: live, bucket, bisection or adaptive";
  add_name(app, "--driver", o.driver, "driver", driver, drivers);
  add_settings(app, o, {kEdits, kCounts, kSample, kSeed, kSchedule, kView, kLight, kLoading},
               left_out);
  add_machine_options(app, o);
  add_flag(app, "--light-groups", o.light_groups,
           {.section = H::kLight,
            .full = "Keep the contribution of each light separately. Changes of lights then show "
                    "at once, without new rays."});
  add_display_options(app, o.display);
}

// Options of the window itself.
void add_window_options(CLI::App* app, ViewOptions& o) {
  add_parsed(app, "--window", "WxH",
             {.section = H::kWindow,
              .brief = "size of the window in pixels",
              .full = "Set the size of the window in pixels.",
              .fallback = "the last size"},
             "WxH from 320x240 on", [&o](const std::string& text) {
               std::array<int, 2> v;
               if (!parse_numbers(text, 'x', v) || v[0] < 320 || v[1] < 240 ||
                   std::max(v[0], v[1]) > 16384) {
                 return false;
               }
               o.window_size = Vec2i(v[0], v[1]);
               return true;
             });
  add_number(app, "--ui-scale", o.interface_scale, 0.5f, 4.0f,
             {.section = H::kWindow,
              .brief = "scale of text and panels",
              .full = "Scale text and panels by this.",
              .fallback = "the screen's"});
  CLI::Option* screenshot =
      add_text(app, "--screenshot", o.screenshot, "FILE",
               {.section = H::kWindow,
                .full = "Write a picture of the window when the frame is done, and close the "
                        "window.",
                .example = "--screenshot window.png"});
  add_number(app, "--screenshot-after", o.screenshot_after_s, 0.001, 1e6,
             {.section = H::kWindow,
              .full = "Take the screenshot this many seconds after the first pass, instead of when "
                      "the frame is done.",
              .example = "--screenshot window.png --screenshot-after 5"})
      ->needs(screenshot);
  CLI::Option* measure =
      add_text(app, "--measure", o.measure, "FILE",
               {.section = H::kWindow,
                .full = "Play edits, write to this file how long each took to show on the screen, "
                        "and close the window."})
          ->excludes(screenshot);
  add_text(app, "--measure-script", o.measure_script, "FILE",
           {.section = H::kWindow,
            .full = "Play the edits of this .json file.",
            .fallback = "orbits, lights, materials and the environment in turn"})
      ->needs(measure);
  add_text(app, "--journal", o.journal, "FILE",
           {.section = H::kWindow,
            .full = "Write a line of JSON to this file for each event of the window."});
  add_flag(app, "--forget", o.forget,
           {.section = H::kWindow,
            .full = "Neither read nor write the remembered size and panels of the window."});
}

// Options for the jobs of a farm.
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
            .full = "Ask for this much memory for each job. SIZE is a number of bytes, or of "
                    "powers of 1024 with K, M, G or T: 8G is 8 GiB.",
            .fallback = "the partition's default",
            .example = "--memory 16G"});
  add_number(app, "--minutes", o.request.minutes, 2, 10000000,
             {.section = H::kJobs,
              .brief = "time limit of each job in minutes",
              .full = "Limit the time of each job to this many minutes. A part saves itself a "
                      "minute before the limit, and `emberline farm retry` continues it.",
              .fallback = "the partition's default"});
  add_flag(app, "--print", o.print,
           {.section = H::kJobs,
            .brief = "print the commands for another queue instead of submitting",
            .full = "Submit nothing. Print the command of a part, with {part} and {parts} as place "
                    "holders, and the command of the merge, for another queue."});
  add_flag(app, "--stage", o.stage,
           {.section = H::kJobs,
            .brief = "copy the scene to the nodes' own disks first",
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

OptionText study_list(const char* brief, const char* full, const std::string& fallback,
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
      study_list("drivers to compare", "Compare these drivers, a comma-separated list.",
                 "bucket,bisection,adaptive"),
      "driver");
  add("--estimators", o.estimators,
      study_list("error estimators of the adaptive driver",
                 "Compare these estimators of the adaptive driver, a comma-separated list of "
                 "ESTIMATOR[/ALLOCATION][/unbiased].",
                 o.estimators, "--estimators nested,kajiya"),
      "estimator");
  CLI::Option* samplers = app->add_option("--samplers", o.samplers)->type_name("LIST");
  describe(samplers,
           study_list("samplers to compare", "Compare these samplers, a comma-separated list.",
                      "sobol; all with --convergence"),
           table_lines(find_setting("sampler")->choices));
  add_text(app, "--spp", o.spp, "LIST",
           study_list("sample counts to measure",
                      "Measure at these samples per pixel (on average), a comma-separated list in "
                      "ascending order.",
                      "1,2,4,8,16,32,64", "--spp 4,16,64"));
  add_text(app, "--seconds", o.seconds, "LIST",
           study_list("times to measure at, instead of sample counts",
                      "Measure after these seconds of rendering instead of at sample counts, a "
                      "comma-separated list in ascending order.",
                      "", "--seconds 1,2,4,8"));
  add_number(app, "--seeds", o.seeds, 1u, kMostStudySeeds,
             study_list("runs of each method, each with another seed",
                        "Run each method this many times, with seeds from `seed` on. With "
                        "--convergence, measure this many pixels.",
                        "5; 2000 with --convergence"));
  add_text(app, "--baseline", o.baseline, "NAME",
           study_list("method that the others are compared with",
                      "Compare the other methods with this one.", "bucket, or the first"));
}

void add_study_choices(CLI::App* app, StudyOptions& o) {
  add_scene(app, o.frame.scene);
  add_text(app, "-o,--output", o.folder, "DIR",
           {.section = H::kStudy,
            .brief = "folder for the results",
            .full = "Write the results to this folder. It is created if it does not exist.",
            .example = "-o study"});
  add_study_methods(app, o);
  add_flag(app, "--denoise", o.denoise,
           {.section = H::kStudy,
            .brief = "also measure each method with its frames denoised",
            .full = "Measure each method a second time as NAME+denoise, with its frames denoised "
                    "and with the denoiser's time included. Implies --separate."});
  add_flag(app, "--separate", o.separate,
           {.section = H::kStudy,
            .full = "Render a separate frame for every budget, even where one frame could be "
                    "measured several times on its way."});
  CLI::Option* reference =
      add_text(app, "--reference", o.reference, "FILE",
               {.section = H::kStudy,
                .brief = "true picture that errors are measured against",
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
            .fallback = "the folder reference in that of the results"})
      ->excludes(reference);
  add_flag(app, "--restart", o.restart,
           {.section = H::kStudy, .full = "Discard the runs that the folder already has."});
  add_flag(app, "--convergence", o.convergence,
           {.section = H::kStudy,
            .brief = "measure the samplers on known integrals, without a scene",
            .full = "Measure variance against the number of samples on integrals with known "
                    "values. This needs no scene."});
}

// Adds option rules to help texts. Settings already have theirs.
void add_option_rules(CLI::App* app) {
  for (CLI::Option* option : app->get_options()) {
    const std::string name = option->get_single_name();
    if (!find_setting(name)) add_rules(option, rules_of(option_rules(), name));
  }
}

}  // namespace

void add_render_options(CLI::App* app, RenderOptions& o) {
  add_argument(app, "scene", o.scene, "The scene: a .gltf or .glb file.")->required();
  add_settings_file(app, o);
  add_result_options(app, o);
  add_range_options(app, o);
  add_settings(app, o,
               {kTurn, kEdits, kChannels, kCounts, kPart, kSample, kSeed, kSchedule, kView, kLight,
                kLoading});
  add_machine_options(app, o);
  add_option_rules(app);
  app->footer(
      "emberline render scene.glb -o picture.png\n"
      "emberline render scene.glb -o frame.exr --driver adaptive --noise-threshold 0.01 --denoise\n"
      "emberline render scene.glb -o shot.####.exr --frames 1-24 --shutter 0,0.5");
}

void add_view_options(CLI::App* app, ViewOptions& o) {
  RenderOptions& r = o.render;
  r.driver = kLiveDriver;
  add_argument(app, "scene", r.scene,
               "The scene: a .gltf or .glb file. Without one, open it in the window.");
  add_settings_file(app, r);
  add_window_options(app, o);
  add_live_options(app, r, {"driver"});
  app->footer(
      "emberline view scene.glb\n"
      "emberline view scene.glb --env sky.hdr --size 1920x1080");
}

void add_session_options(CLI::App* app, SessionOptions& o) {
  add_settings_file(app, o.render);
  add_name(app, "--format", o.format, "format",
           {.section = H::kSession,
            .brief = "pixels that the host gets: linear or display",
            .full = "Choose the format in which the host program gets pictures.",
            .fallback = "linear"},
           kPictureFormats);
  add_name(
      app, "--overlay", o.overlay, "overlay",
      {.section = H::kSession, .full = "Show this instead of the picture.", .fallback = "none"},
      overlay_table());
  add_parsed(app, "--region", "X0,Y0,X1,Y1",
             {.section = H::kSession, .full = "Sample these pixels first. X1 and Y1 are excluded."},
             "X0,Y0,X1,Y1 in whole pixels", [&o](const std::string& text) {
               std::array<int, 4> v;
               if (!parse_numbers(text, ',', v)) return false;
               o.region = Rect{v[0], v[1], v[2], v[3]};
               return v[0] >= 0 && v[1] >= 0 && !o.region->empty();
             });
  add_flag(app, "--paused", o.paused, {.section = H::kSession, .full = "Pause the frame."});
  add_flag(app, "--denoise", o.denoise,
           {.section = H::kSession,
            .full = "Denoise the pictures that the host gets. Saved pictures are not denoised."});
  add_live_options(app, o.render, {"driver", "edits", "panorama", "working-space"});
}

void add_info_options(CLI::App* app, InfoOptions& o) {
  CLI::Option* scene = add_argument(app, "scene", o.scene, "The scene: a .gltf or .glb file.");
  add_flag(app, "--channels", o.channels,
           {.section = H::kOutput,
            .brief = "list the channels that pictures can have, without a scene",
            .full = "List the channels that pictures can have. This needs no scene."})
      ->excludes(scene);
  add_json(app, o.json);
  add_settings(app, o.settings, {kLoading});
  add_limits(app, o.limits);
  app->footer(
      "emberline info scene.glb\n"
      "emberline info --channels");
}

void add_heatmap_options(CLI::App* app, HeatmapOptions& o) {
  o.quantity = heatmap_quantity_table().front().name;
  add_argument(app, "image", o.image, "An .exr file that `emberline render` wrote.")->required();
  add_text(app, "-o,--output", o.output, "FILE",
           {.section = H::kOutput,
            .brief = "heatmap to write: .png, .jpg or .exr",
            .full = "Write the heatmap to this file. .png, .jpg files have a legend; an .exr file "
                    "has the numbers alone."})
      ->required();
  describe(app->add_option("--of", o.quantity)->type_name("NAME"),
           {.section = H::kOutput,
            .brief = "what to show: samples, error, stop, time, ...",
            .full = "Choose what the heatmap shows.",
            .fallback = "samples",
            .example = "--of error"},
           table_lines(heatmap_quantity_table()));
  add_heatmap_style(app, o.style, nullptr);
  add_limits(app, o.limits);
  app->footer("emberline heatmap frame.exr -o error.png --of error --colors viridis");
}

void add_compare_options(CLI::App* app, CompareOptions& o) {
  add_argument(app, "image", o.image, "The picture to measure.")->required();
  add_argument(app, "reference", o.reference, "The picture that it should be.")->required();
  add_json(app, o.json);
  add_text(app, "-o,--difference", o.difference, "FILE",
           {.section = H::kOutput,
            .brief = "picture of the difference: FLIP as .png, signed as .exr",
            .full = "Write a picture of the difference: a .png file shows FLIP in false colour, an "
                    ".exr file has the signed difference."});
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f,
             {.section = H::kOutput,
              .brief = "brighten both pictures by this many stops for FLIP, SSIM, PSNR",
              .full = "Brighten both pictures by this many stops for FLIP, SSIM and PSNR.",
              .fallback = "0"});
  add_limits(app, o.limits);
  app->footer("emberline compare frame.exr reference.exr -o flip.png");
}

void add_denoise_options(CLI::App* app, DenoiseOptions& o) {
  add_argument(app, "frame", o.image, "An .exr file that `emberline render --aov denoising` wrote.")
      ->required();
  add_text(app, "-o,--output", o.outputs, "FILE",
           {.section = H::kOutput,
            .brief = "picture to write: .exr, .png or .jpg",
            .full = "Write the result to this file. An .exr file has all channels of the frame, "
                    "denoised.{R,G,B} and denoised.error; .png, .jpg files show the denoised "
                    "picture. May be given more than once."})
      ->required();
  add_display_options(app, o.display);
  add_threads(app, o.threads);
  add_limits(app, o.limits);
  app->footer(
      "emberline render scene.glb -o frame.exr --aov denoising\n"
      "emberline denoise frame.exr -o clean.png");
}

void add_extend_options(CLI::App* app, ExtendOptions& o) {
  add_argument(app, "frame", o.frame,
               "A picture that was rendered with --resumable, or its checkpoint.")
      ->required();
  add_text(app, "--scene", o.scene, "FILE",
           {.section = H::kScene,
            .brief = "where the scene is now, if it was moved",
            .full = "Read the scene from this file.",
            .fallback = "the file that the frame was rendered from"});
  for (const char* name : {"spp", "noise-threshold", "max-spp", "time-limit"}) {
    add_setting(app, *find_setting(name), o.more);
  }
  add_outputs(app, o.more,
              {.section = H::kOutput,
               .brief = "picture to write: .exr, .png or .jpg",
               .full = "Write the picture to this file: .exr, .png or .jpg. May be given more than "
                       "once.",
               .fallback = "the frame's own file"},
              {.section = H::kOutput,
               .brief = "report of the render: .html or .json",
               .full = "Write a report of the render: .html or .json."});
  add_checkpoint_interval(app, o.more);
  add_machine_options(app, o.more);
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
  // Not required, because the subcommands take no scene.
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
               {"time-limit"});
  app->require_subcommand(0, 1);
  add_farm_verb(app, o, FarmVerb::kStatus, "status",
                "Show the progress of the parts and failures.");
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
  app->allow_extras();  // an option with its dashes
  app->footer(
      "emberline help render\n"
      "emberline help render noise-threshold");
}

}  // namespace emberline
