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

void add_snapshots(CLI::App* app, RenderOptions& o) {
  CLI::Option* snapshots =
      add_text(app, "--snapshots", o.snapshots, "DIR",
               "keep the picture at several moments of the render in this folder, and all of them "
               "as refinement.gif; a copy of each (16 bytes a pixel) is held in memory until the "
               "frame is done");
  add_text(app, "--snapshot-at", o.snapshot_at, "LIST",
           fmt::format("when: a list of 'first', N% of the pixels having a sample, Ns of "
                       "rendering, Nspp on average [{}]",
                       kDefaultSnapshotMoments))
      ->needs(snapshots);
  add_name(app, "--snapshot-format", o.snapshot_format, "format", "what is written of each [png]",
           snapshot_format_table())
      ->needs(snapshots);
  add_text(app, "--reference", o.reference, "FILE",
           "measure each snapshot against this picture, into the report")
      ->needs(snapshots);
}

void add_display(CLI::App* app, RenderOptions& o) {
  app->add_option_function<std::vector<std::string>>(
         "--display",
         [&o](const std::vector<std::string>& values) {
           for (const std::string& value : values) {
             if (is_tev_url(value)) {
               o.viewer = parse_tev_url(value);
             } else {
               o.display.display = value;
             }
           }
         },
         fmt::format("OpenColorIO display [the config's default]; or tev://HOST:PORT: show the "
                     "picture in the viewer tev while it renders (port {} unless given). May be "
                     "given once for each",
                     TevAddress::kDefaultPort))
      ->type_name("NAME|URL")
      ->allow_extra_args(false);
}

void add_checkpoint_interval(CLI::App* app, RenderOptions& o) {
  add_number(app, "--checkpoint-interval", o.checkpoint_interval_s, 0.1, 1e9,
             "seconds between two checkpoints [300]; SIGUSR1 asks for one at once");
}

void add_checkpoint(CLI::App* app, RenderOptions& o) {
  add_text(app, "--checkpoint", o.checkpoint, "FILE",
           "keep what there is of the frame in this file while it renders, for --resume; it goes "
           "when the frame is done. A file that is no checkpoint is not replaced");
  app->add_flag("--resumable", o.resumable,
                "the same beside the first output (FILE.checkpoint), unless --checkpoint names "
                "another; and it stays, for `emberline extend`");
  app->add_flag("--resume", o.resume,
                "go on with the checkpoint, to the same bits; without one the frame begins anew");
  add_checkpoint_interval(app, o);
  add_text(app, "--progress-file", o.progress_file, "FILE",
           "say in this .json file, every two seconds, how far the frame is");
}

void add_range_options(CLI::App* app, RenderOptions& o) {
  app->add_option_function<std::string>(
         "--frames", [&o](const std::string& text) { o.frames = parse_frames(text); },
         "frames one after another: N, A-B, A-BxSTEP, or a list of those. #### in the names of "
         "outputs is the frame's number; frame N shows the scene at N / --fps seconds")
      ->type_name("LIST");
  app->add_flag("--skip-existing", o.skip_existing,
                "leave out a frame whose outputs are all there and whole");
  app->add_flag("--stop-on-error", o.stop_on_error,
                "end the range with the first frame that fails [the others are rendered]");
  add_text(app, "--range-report", o.range_report, "FILE",
           "what became of each frame, as JSON; --report is of one frame");
}

void add_result_options(CLI::App* app, RenderOptions& o) {
  add_text(app, "-o,--output", o.outputs, "FILE",
           "picture: .exr linear with all channels, streamed; .png, .jpg through OpenColorIO, held "
           "in memory until done. May be given more than once");
  add_heatmaps(app, o);
  add_text(app, "--report", o.reports, "FILE",
           "what was done: .html is a page with pictures and charts, .json or any other name JSON. "
           "May be given more than once");
  add_snapshots(app, o);
  add_checkpoint(app, o);
  add_text(app, "--save-settings", o.save_settings, "FILE",
           "write what differs from the defaults to this .json file, for --settings");
  add_text(app, "--replay", o.replay, "X,Y,SAMPLE", "compute one sample alone and print it");
  add_parsed(app, "--explain", "X,Y", "after the render, print what decided this pixel's samples",
             "X,Y in whole pixels of the frame", [&o](const std::string& text) {
               std::array<int, 2> v;
               if (!parse_numbers(text, ',', v) || v[0] < 0 || v[1] < 0) return false;
               o.explained = Vec2i(v[0], v[1]);
               return true;
             });
  add_text(app, "--tree", o.trees, "FILE",
           "the refinement tree: leaves drawn over the picture (.png, .jpg), or .json. May be "
           "given more than once");
  add_display(app, o);
  add_grading(app, o.display);
}

const SettingChoice kPictureFormats[] = {{"linear", "four floats a pixel, linear Rec. 709"},
                                         {"display", "four bytes, through OpenColorIO"}};

// Frame options that the window and a session share.
void add_live_options(CLI::App* app, RenderOptions& o,
                      std::initializer_list<std::string_view> left_out) {
  std::vector<SettingChoice> drivers = find_setting("driver")->choices;
  drivers.insert(
      drivers.begin(),
      {kLiveDriver,
       "bisection until every pixel has a sample, then adaptive, whose settings it takes"});
  add_name(app, "--driver", o.driver, "driver", "frame driver [live]", drivers);
  add_settings(app, o, {kEdits, kCounts, kSample, kSeed, kSchedule, kView, kLight, kLoading},
               left_out);
  add_machine_options(app, o);
  app->add_flag("--light-groups", o.light_groups,
                "keep what each light gives apart: changes of lights then need no new ray");
  add_display_options(app, o.display);
}

// Options of the window itself.
void add_window_options(CLI::App* app, ViewOptions& o) {
  add_parsed(app, "--window", "WxH", "size of the window [as last time]", "WxH from 320x240 on",
             [&o](const std::string& text) {
               std::array<int, 2> v;
               if (!parse_numbers(text, 'x', v) || v[0] < 320 || v[1] < 240 ||
                   std::max(v[0], v[1]) > 16384) {
                 return false;
               }
               o.window_size = Vec2i(v[0], v[1]);
               return true;
             });
  add_number(app, "--ui-scale", o.interface_scale, 0.5f, 4.0f,
             "size of letters and panels [the screen's]");
  CLI::Option* screenshot =
      add_text(app, "--screenshot", o.screenshot, "FILE",
               "write a picture of the window when the frame is done, and close");
  add_number(app, "--screenshot-after", o.screenshot_after_s, 0.001, 1e6,
             "not when the frame is done, but so many seconds after its first pass")
      ->needs(screenshot);
  CLI::Option* measure =
      add_text(app, "--measure", o.measure, "FILE",
               "play edits, write how long each took to be on the screen, and close")
          ->excludes(screenshot);
  add_text(app, "--measure-script", o.measure_script, "FILE",
           "the edits, a .json file [orbits, lights, materials and environment in turn]")
      ->needs(measure);
  add_text(app, "--journal", o.journal, "FILE", "what the window does, a line of JSON each");
  app->add_flag("--forget", o.forget,
                "neither read nor write the size and the panels of the window");
}

// Options for the jobs of a farm.
void add_job_options(CLI::App* app, FarmOptions& o) {
  add_number(app, "--parts", o.parts, 1u, 4096u, "how many jobs share the frame");
  add_text(app, "--frames", o.frames, "LIST", "of several frames none yet: 0 alone [0]")
      ->check([](const std::string& list) {
        return list == "0"
                   ? ""
                   : "--frames: '" + list +
                         "': the only frame is 0, since farm renders one, in parts; of a range "
                         "each job is an `emberline render --frames` of its own";
      });
  add_text(app, "--partition", o.request.partition, "LIST", "of Slurm [its default]");
  add_number(app, "--cpus", o.request.cpus, 1, 4096, "processors of each job [a whole node]");
  add_size(app, "--memory", o.request.memory_bytes,
           "memory of each job: bytes, or with K, M, G, T powers of 1024 of them [the "
           "partition's]");
  add_number(app, "--minutes", o.request.minutes, 2, 10000000,
             "minutes of each job; a minute before, a part saves itself, for farm retry [the "
             "partition's]");
  app->add_flag(
      "--print", o.print,
      "submit nothing; print the command of a part, with {part} and {parts}, and that of the "
      "merge, for another queue");
  app->add_flag("--stage", o.stage, "copy the scene to each node's $TMPDIR first, once");
}

void add_farm_verb(CLI::App* app, FarmOptions& o, FarmVerb verb, const char* name,
                   const char* help) {
  CLI::App* sub = app->add_subcommand(name, help);
  sub->add_option("output", o.output, "the output that was given to farm")->required();
  sub->parse_complete_callback([&o, verb] { o.verb = verb; });
  if (verb == FarmVerb::kStatus) sub->add_flag("--json", o.json, "machine-readable");
}

void add_study_choices(CLI::App* app, StudyOptions& o) {
  app->add_option("scene", o.frame.scene, "a .gltf or .glb file");
  add_text(app, "-o,--output", o.folder, "DIR",
           "folder of the results; it is made if it is not there");
  add_text(app, "--drivers", o.drivers, "LIST",
           table_help("frame drivers, a list [bucket,bisection,adaptive]",
                      find_setting("driver")->choices));
  add_text(app, "--estimators", o.estimators, "LIST",
           table_help("of the adaptive driver, a list of ESTIMATOR[/ALLOCATION][/unbiased] [" +
                          o.estimators + "]",
                      find_setting("estimator")->choices));
  add_text(app, "--samplers", o.samplers, "LIST",
           table_help("samplers, a list [sobol; of --convergence all]",
                      find_setting("sampler")->choices));
  add_text(app, "--spp", o.spp, "LIST",
           "budgets: samples per pixel on average, ascending [1,2,4,8,16,32,64]");
  add_text(app, "--seconds", o.seconds, "LIST", "budgets: seconds of rendering instead, ascending");
  add_number(app, "--seeds", o.seeds, 1u, kMostStudySeeds,
             "runs of each method, from --seed on [5]; of --convergence pixels [2000]");
  add_text(app, "--baseline", o.baseline, "NAME",
           "the method that others are compared with [the first]");
  app->add_flag("--denoise", o.denoise,
                "each method once more, NAME+denoise: what --denoise makes of its frames, the "
                "filter's time included; implies --separate");
  app->add_flag("--separate", o.separate,
                "render a frame of its own for every budget, also where one frame could be looked "
                "at on its way");
  CLI::Option* reference = add_text(app, "--reference", o.reference, "FILE",
                                    "the true picture [one is rendered, in two halves, so that its "
                                    "own noise is taken out]");
  add_number(app, "--reference-spp", o.reference_spp, 2u, kMaxSamples,
             "samples per pixel of the rendered reference [64 times the largest budget's]")
      ->excludes(reference);
  add_text(app, "--cache", o.cache, "DIR",
           "keep rendered references in this folder [DIR/reference]")
      ->excludes(reference);
  app->add_flag("--restart", o.restart, "forget the runs that the folder has");
  app->add_flag("--convergence", o.convergence,
                "no scene: variance against number of samples, on integrals with known values");
}

// Adds option rules to help texts. Settings already have theirs.
void add_option_rules(CLI::App* app) {
  for (CLI::Option* option : app->get_options()) {
    const std::string name = option->get_single_name();
    if (find_setting(name)) continue;
    option->description(option->get_description() + rules_of(option_rules(), name));
  }
}

}  // namespace

void add_render_options(CLI::App* app, RenderOptions& o) {
  app->add_option("scene", o.scene, "a .gltf or .glb file")->required();
  add_settings_file(app, o);
  add_result_options(app, o);
  add_range_options(app, o);
  add_settings(app, o,
               {kTurn, kEdits, kChannels, kCounts, kPart, kSample, kSeed, kSchedule, kView, kLight,
                kLoading});
  add_machine_options(app, o);
  add_option_rules(app);
}

void add_view_options(CLI::App* app, ViewOptions& o) {
  RenderOptions& r = o.render;
  r.driver = kLiveDriver;
  app->add_option("scene", r.scene, "a .gltf or .glb file [one is opened in the window]");
  add_settings_file(app, r);
  add_window_options(app, o);
  add_live_options(app, r, {"driver"});
}

void add_session_options(CLI::App* app, SessionOptions& o) {
  add_settings_file(app, o.render);
  add_name(app, "--format", o.format, "format", "what the host gets of pictures [linear]",
           kPictureFormats);
  add_name(app, "--overlay", o.overlay, "overlay", "shown in place of the picture [none]",
           overlay_table());
  add_parsed(app, "--region", "X0,Y0,X1,Y1",
             "pixels that get their samples first, X1 and Y1 excluded",
             "X0,Y0,X1,Y1 in whole pixels", [&o](const std::string& text) {
               std::array<int, 4> v;
               if (!parse_numbers(text, ',', v)) return false;
               o.region = Rect{v[0], v[1], v[2], v[3]};
               return v[0] >= 0 && v[1] >= 0 && !o.region->empty();
             });
  app->add_flag("--paused", o.paused, "the frame stands still");
  app->add_flag("--denoise", o.denoise, "pictures are filtered; what is saved is not");
  add_live_options(app, o.render, {"driver", "edits", "panorama", "working-space"});
}

void add_info_options(CLI::App* app, InfoOptions& o) {
  CLI::Option* scene = app->add_option("scene", o.scene, "a .gltf or .glb file");
  app->add_flag("--channels", o.channels, "the channels that pictures can have, without a scene")
      ->excludes(scene);
  app->add_flag("--json", o.json, "machine-readable");
  add_settings(app, o.settings, {kLoading});
  add_limits(app, o.limits);
}

void add_heatmap_options(CLI::App* app, HeatmapOptions& o) {
  o.quantity = heatmap_quantity_table().front().name;
  app->add_option("image", o.image, "an .exr that render wrote")->required();
  add_text(app, "-o,--output", o.output, "FILE",
           "picture with legend: .png, .jpg; .exr: the numbers alone")
      ->required();
  add_text(app, "--of", o.quantity, "NAME",
           table_help("what it shows [samples]", heatmap_quantity_table()));
  add_heatmap_style(app, o.style, nullptr);
  add_limits(app, o.limits);
}

void add_compare_options(CLI::App* app, CompareOptions& o) {
  app->add_option("image", o.image, "the image")->required();
  app->add_option("reference", o.reference, "what it should be")->required();
  app->add_flag("--json", o.json, "machine-readable");
  add_text(app, "-o,--difference", o.difference, "FILE",
           "difference picture: FLIP as .png, signed difference as .exr");
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f, "stops, for FLIP, SSIM and PSNR [0]");
  add_limits(app, o.limits);
}

void add_denoise_options(CLI::App* app, DenoiseOptions& o) {
  app->add_option("frame", o.image, "an .exr that render wrote with --aov denoising")->required();
  add_text(app, "-o,--output", o.outputs, "FILE",
           ".exr: all channels of the frame, and denoised.{R,G,B} and denoised.error; .png, .jpg: "
           "the clean picture. May be given more than once")
      ->required();
  add_display_options(app, o.display);
  add_number(app, "--threads", o.threads, 1, kMostThreads,
             "worker threads [one for each processor that the process may use]");
  add_limits(app, o.limits);
}

void add_extend_options(CLI::App* app, ExtendOptions& o) {
  app->add_option("frame", o.frame,
                  "a picture that was rendered with --resumable, or its checkpoint")
      ->required();
  add_text(app, "--scene", o.scene, "FILE", "where its scene is now [where it was]");
  for (const char* name : {"spp", "noise-threshold", "max-spp", "time-limit"}) {
    add_setting(app, *find_setting(name), o.more);
  }
  add_outputs(app, o.more, "picture, as of render; may be given more than once [the frame's own]",
              "what was done, as of render");
  add_checkpoint_interval(app, o.more);
  add_machine_options(app, o.more);
}

void add_merge_options(CLI::App* app, MergeOptions& o) {
  app->add_option("parts", o.parts,
                  "checkpoints that render --part, --sample-range or --resumable "
                  "has kept; several seeds of a frame are averaged")
      ->required();
  add_outputs(app, o.frame,
              "picture: .exr, .png or .jpg, as of render. May be given more than once",
              "what the parts come to, as JSON");
  app->add_flag("--allow-holes", o.allow_holes,
                "write a frame of which parts are missing: its pixels are black, their stop is 0");
  app->add_flag("--strict", o.strict, "refuse parts from several kinds of machine");
  add_machine_options(app, o.frame);
}

void add_farm_options(CLI::App* app, FarmOptions& o) {
  // Not required, because the subcommands take no scene.
  app->add_option("scene", o.frame.scene, "a .gltf or .glb file");
  add_settings_file(app, o.frame);
  add_outputs(app, o.frame,
              "picture: .exr, .png or .jpg, as of render; beside the first, FILE.farm has the "
              "jobs. #### in a name is the frame's number. May be given more than once",
              "what the parts come to, as JSON");
  add_job_options(app, o);
  add_settings(app, o.frame,
               {kEdits, kChannels, kCounts, kSample, kSeed, kSchedule, kView, kLight, kLoading},
               {"time-limit"});
  app->require_subcommand(0, 1);
  add_farm_verb(app, o, FarmVerb::kStatus, "status", "how far the parts are, and what failed");
  add_farm_verb(app, o, FarmVerb::kCancel, "cancel", "end the jobs; what is done stays");
  add_farm_verb(app, o, FarmVerb::kRetry, "retry",
                "submit the parts that are missing, and the merge");
}

void add_study_options(CLI::App* app, StudyOptions& o) {
  o.frame.width = 320;
  o.frame.height = 180;
  add_study_choices(app, o);
  add_settings(app, o.frame, kStudySettings);
  add_machine_options(app, o.frame);
}

}  // namespace emberline
