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

void add_snapshots(CLI::App* app, RenderOptions& o) {
  CLI::Option* snapshots =
      add_text(app, "--snapshots", o.snapshots, "DIR",
               {.section = H::kInspection,
                .full = "Save the picture to this folder at several moments of the render, and an "
                        "animation of them as refinement.gif. Each snapshot takes 16 bytes of "
                        "memory per pixel until the frame is done.",
                .example = "--driver bisection --snapshots shots"});
  add_text(app, "--snapshot-at", o.snapshot_at, "LIST",
           {.section = H::kInspection,
            .full = "Take snapshots at these moments, a comma-separated list: 'first' is the first "
                    "picture, N% is when that share of the pixels has a sample, Ns is after N "
                    "seconds of rendering, and Nspp is at an average of N samples per pixel.",
            .fallback = std::string(kDefaultSnapshotMoments),
            .example = "--snapshots shots --snapshot-at first,10s,60s"})
      ->needs(snapshots);
  add_name(
      app, "--snapshot-format", o.snapshot_format, "format",
      {.section = H::kInspection, .full = "Choose the format of snapshots.", .fallback = "png"},
      snapshot_format_table())
      ->needs(snapshots);
  add_text(
      app, "--reference", o.reference, "FILE",
      {.section = H::kInspection,
       .full =
           "Measure the error of each snapshot against this picture, and add it to the report."})
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
            .full = fmt::format("Convert the picture for this OpenColorIO display. Or, with "
                                "tev://HOST:PORT, show it in the viewer tev while it renders; the "
                                "default port is {}. To do both, give the option twice.",
                                TevAddress::kDefaultPort),
            .fallback = "the config's default",
            .example = "--display tev://localhost"});
}

void add_progress_file(CLI::App* app, RenderOptions& o) {
  add_text(app, "--progress-file", o.progress_file, "FILE",
           {.section = H::kOutput,
            .full = "Write the progress of the frame to this .json file every two seconds."});
}

void add_checkpoint(CLI::App* app, RenderOptions& o) {
  add_text(app, "--checkpoint", o.checkpoint, "FILE",
           {.section = H::kOutput,
            .full = "Save the state of the frame in this file while it renders, so that `resume` "
                    "can continue it. The file is removed when the frame is done. A file that is "
                    "not a checkpoint is never replaced.",
            .example = "--checkpoint frame.checkpoint --resume"});
  add_flag(
      app, "--resumable", o.resumable,
      {.section = H::kOutput,
       .brief = "keep a checkpoint, for --resume and `emberline extend`",
       .full = "Save a checkpoint beside the first output (FILE.checkpoint) or in the file of "
               "`checkpoint`. The checkpoint is kept after the frame is done, so that `emberline "
               "extend` can add samples."});
  add_flag(app, "--resume", o.resume,
           {.section = H::kOutput,
            .brief = "continue an interrupted frame from its checkpoint",
            .full = "Continue from the checkpoint. The picture has the same bits as without the "
                    "interruption. If there is no checkpoint, the frame starts over.",
            .example = "--resumable --resume"});
  add_checkpoint_interval(app, o);
  add_progress_file(app, o);
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
  add_number(app, "--across", o.across, 0, kMaxAcross,
             {.section = H::kOutput,
              .full = std::string(kAcrossText) +
                      " Requires --denoise, several frames and an .exr output. A frame is "
                      "denoised once its neighbours are rendered, as `emberline denoise` does. "
                      "`noise-threshold` is then the noise of the combined frames, unless `judge` "
                      "is given.",
              .example = "--frames 1-24 --denoise --across 2 -o shot.####.exr"});
  add_flag(
      app, "--skip-existing", o.skip_existing,
      {.section = H::kOutput, .full = "Skip frames whose outputs all exist and are complete."});
  add_flag(app, "--stop-on-error", o.stop_on_error,
           {.section = H::kOutput,
            .full = "Stop at the first frame that fails. Otherwise the other frames are still "
                    "rendered."});
  add_text(app, "--range-report", o.range_report, "FILE",
           {.section = H::kOutput,
            .full = "Write the result of each frame to this file: a .html file is a page with an "
                    "animation (if there is an .exr output), charts and a table, any other file is "
                    "JSON. `report` describes a single frame."});
}

void add_result_options(CLI::App* app, RenderOptions& o) {
  add_text(
      app, "-o,--output", o.outputs, "FILE",
      {.section = H::kOutput,
       .brief = "picture to write: .exr, .png or .jpg",
       .full =
           "Write the picture to this file. An .exr file has all channels in linear floats and is "
           "written while the frame renders. .png and .jpg files are converted for display by "
           "OpenColorIO and kept in memory until the frame is done. May be given more than once.",
       .example = "-o frame.exr -o frame.png"});
  add_heatmaps(app, o);
  add_text(app, "--report", o.reports, "FILE",
           {.section = H::kOutput,
            .brief = "report of the render: .html or .json",
            .full = "Write a report of the render. An .html file is a page with pictures and "
                    "charts; .json or any other name gives JSON. May be given more than once.",
            .example = "--report frame.html"});
  add_flag(
      app, "--strict", o.strict,
      {.section = H::kLimits,
       .full = "End with exit code 1 if `time-limit` leaves black pixels, as `driver` bucket "
               "does. Other drivers fill in pixels without a sample from their neighbours; the "
               "report counts them. The picture and the report are still written. With "
               "`resume` the exit code is 130, as without this option.",
       .example = "--time-limit 60 --strict"});
  add_snapshots(app, o);
  add_checkpoint(app, o);
  add_text(app, "--save-settings", o.save_settings, "FILE",
           {.section = H::kGeneral,
            .full = "Write the settings that differ from the defaults to this .json file, which "
                    "`settings` can read."});
  add_text(app, "--replay", o.replay, "X,Y,SAMPLE",
           {.section = H::kInspection,
            .full = "Compute only this sample of a pixel, and print it.",
            .example = "--replay 100,50,7"});
  add_parsed(app, "--explain", "X,Y",
             {.section = H::kInspection,
              .full = "After the render, explain why this pixel got its number of samples. An EXR "
                      "keeps the history of the pixel for `emberline explain`.",
              .example = "--driver adaptive --explain 100,50"},
             "X,Y in whole pixels of the frame", [&o](const std::string& text) {
               std::array<int, 2> v;
               if (!parse_numbers(text, ',', v) || v[0] < 0 || v[1] < 0) return false;
               o.explained = Vec2i(v[0], v[1]);
               return true;
             });
  add_text(
      app, "--tree", o.trees, "FILE",
      {.section = H::kInspection,
       .full =
           "Write the refinement tree of the adaptive driver: .png and .jpg files show its leaves "
           "over the picture, and a .json file has its data. May be given more than once.",
       .example = "--driver adaptive --tree tree.png"});
  add_display(app, o);
  add_grading(app, o.display);
}

const SettingChoice kPictureFormats[] = {
    {"linear", "four floats per pixel, in linear Rec. 709"},
    {"display", "four bytes per pixel, converted for display by OpenColorIO"}};

// Adds the frame options that the window and a session share.
void add_live_options(CLI::App* app, RenderOptions& o,
                      std::initializer_list<std::string_view> excluded) {
  std::vector<SettingChoice> drivers = find_setting("driver")->choices;
  drivers.insert(drivers.begin(), {kLiveDriver,
                                   "bisection until every pixel has a sample, then adaptive; "
                                   "accepts the settings of adaptive"});
  OptionText driver = find_setting("driver")->help;
  driver.fallback = kLiveDriver;
  driver.brief = "rendering order: live, bucket, bisection or adaptive";
  add_name(app, "--driver", o.driver, "driver", driver, drivers);
  add_settings(app, o, {kEdits, kCounts, kSample, kSeed, kSchedule, kView, kLight, kLoading},
               excluded);
  add_machine_options(app, o);
  add_flag(app, "--light-groups", o.light_groups,
           {.section = H::kLight,
            .full = "Store the contribution of each light separately. Changes to lights then show "
                    "at once, without new rays."});
  add_display_options(app, o.display);
}

void add_window_options(CLI::App* app, ViewOptions& o) {
  add_parsed(app, "--window", "WxH",
             {.section = H::kWindow,
              .brief = "size of the window in pixels",
              .full = "Set the size of the window in pixels.",
              .fallback = "the last size"},
             "WxH from 320x240 to 16384x16384", [&o](const std::string& text) {
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
              .full = "Scale text and panels by this factor.",
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
  CLI::Option* measure = add_text(app, "--measure", o.measure, "FILE",
                                  {.section = H::kWindow,
                                   .full = "Play edits, write to this file how long each one took "
                                           "to appear on the screen, and close the window."})
                             ->excludes(screenshot);
  add_text(app, "--measure-script", o.measure_script, "FILE",
           {.section = H::kWindow,
            .full = "Play the edits of this .json file.",
            .fallback = "orbits, lights, materials and the environment in turn"})
      ->needs(measure);
  add_text(app, "--journal", o.journal, "FILE",
           {.section = H::kWindow,
            .full = "Write a line of JSON to this file for each event of the window."});
  add_flag(
      app, "--forget", o.forget,
      {.section = H::kWindow,
       .full = "Ignore the remembered size and panels of the window, and do not save new ones."});
}

// Adds the rules of the options to their help texts. Skips settings, whose help already has their
// rules.
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

void add_plan_options(CLI::App* app, PlanOptions& o) {
  RenderOptions& frame = o.frame;
  frame.driver = "adaptive";
  add_argument(app, "scene", frame.scene, "The scene: a .gltf or .glb file.")->required();
  add_settings_file(app, frame);
  add_text(app, "-o,--output", o.output, "FILE",
           {.section = H::kOutput,
            .brief = "plan to write",
            .full = "Write the plan to this file. A file that is not a plan is never replaced.",
            .example = "-o frame.plan"});
  add_flag(app, "--resume", frame.resume,
           {.section = H::kOutput,
            .brief = "continue an interrupted command",
            .full = "Save the state in FILE.checkpoint, and continue from it if an interrupted "
                    "command with --resume has left one. The plan has the same bits as without the "
                    "interruption.",
            .example = "--resume -o frame.plan"});
  add_checkpoint_interval(app, frame);
  add_progress_file(app, frame);
  add_settings(
      app, frame,
      {kTurn, kEdits, kChannels, kCounts, kSample, kSeed, kSchedule, kView, kLight, kLoading},
      {"time-limit", "time-budget"});
  add_machine_options(app, frame);
  app->footer(
      "emberline plan scene.glb --spp 256 -o frame.plan\n"
      "emberline render scene.glb --driver adaptive --spp 256 --plan frame.plan --part 1/8 -o "
      "frame.exr");
}

void add_view_options(CLI::App* app, ViewOptions& o) {
  RenderOptions& r = o.render;
  r.driver = kLiveDriver;
  add_argument(app, "scene", r.scene,
               "The scene: a .gltf or .glb file. Without one, open it in the window.");
  add_settings_file(app, r);
  add_window_options(app, o);
  add_live_options(app, r, {"driver", "static-noise"});
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
  add_flag(app, "--paused", o.paused, {.section = H::kSession, .full = "Pause rendering."});
  add_flag(app, "--denoise", o.denoise,
           {.section = H::kSession,
            .full = "Denoise the pictures that the host gets. Saved pictures are not denoised."});
  add_live_options(app, o.render, {"driver", "edits", "panorama", "static-noise", "working-space"});
}

}  // namespace emberline
