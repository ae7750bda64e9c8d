#include "renderer/app/command_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "renderer/app/number_option.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/frame/bucket_schedule.h"
#include "renderer/output/snapshots.h"

namespace emberline {
namespace {

// "name: summary" lines of a table, for --help.
template <typename Table>
std::string table_help(const char* what, const Table& table) {
  std::string text = what;
  for (const auto& entry : table) {
    text += fmt::format("\n  {}: {}", entry.name, entry.summary);
  }
  return text;
}

// An option whose value is a name of `table`, looked up at once: not when the scene has been
// loaded.
template <typename Table, typename Target>
CLI::Option* add_name(CLI::App* app, const std::string& option, Target& target, const char* kind,
                      const char* help, const Table& table) {
  return app->add_option(option, target, table_help(help, table))
      ->type_name("NAME")
      ->check([=](const std::string& name) {
        find_named(table, option, kind, name);
        return std::string();
      });
}

struct NamedDriver {
  std::string_view name, summary;
};

// Far beyond any scene, near enough that squares of distances stay finite in double and float's
// rounding of the rebased scene is what limits the picture.
constexpr double kFarthest = 1e15;

// The ends of --range: squares stay finite in float, and steps between them are told apart.
constexpr double kMostOfRange = 1e18, kLeastOfRange = 1e-30, kNearestOfRange = 1e-6;

bool is_value_range(double least, double most) {
  const double greatest = std::max(std::abs(least), std::abs(most));
  return greatest <= kMostOfRange && greatest >= kLeastOfRange &&
         most - least >= kNearestOfRange * greatest;
}

// --f-stop, to either side: scenes come in any size.
constexpr double kMostOfLens = 1e9;

// --time-limit in seconds: a millisecond to thirty years.
constexpr double kLeastTimeLimit = 0.001, kMostTimeLimit = 1e9;

CLI::Option* add_vector(CLI::App* app, const std::string& name, std::optional<Vec3d>& target,
                        const std::string& help) {
  return app
      ->add_option_function<std::string>(
          name,
          [&target, name](const std::string& text) {
            std::array<double, 3> v;
            if (!parse_numbers(text, ',', v) ||
                std::ranges::any_of(v, [](double c) { return std::abs(c) > kFarthest; })) {
              throw CLI::ValidationError(
                  name, fmt::format("'{}' is not X,Y,Z with numbers from -{} to {}", text,
                                    kFarthest, kFarthest));
            }
            target = Vec3d(v[0], v[1], v[2]);
          },
          help)
      ->type_name("X,Y,Z");
}

void add_frame_options(CLI::App* app, RenderOptions& o) {
  app->add_option_function<std::string>(
         "--size",
         [&o](const std::string& text) {
           std::array<int, 2> v;
           if (!parse_numbers(text, 'x', v) || v[0] < 1 || v[1] < 1 || v[0] > 65536 ||
               v[1] > 65536) {
             throw CLI::ValidationError("--size",
                                        "'" + text + "' is not WxH with 1 to 65536 pixels each");
           }
           o.width = v[0];
           o.height = v[1];
         },
         fmt::format("frame in pixels [{}x{}]", o.width, o.height))
      ->type_name("WxH");
  app->add_option_function<std::string>(
         "--crop",
         [&o](const std::string& text) {
           std::array<int, 4> v;
           if (!parse_numbers(text, ',', v)) {
             throw CLI::ValidationError("--crop",
                                        "'" + text + "' is not X0,Y0,X1,Y1 in whole pixels");
           }
           o.crop = Rect{v[0], v[1], v[2], v[3]};
         },
         "render these pixels only, X1 and Y1 excluded")
      ->type_name("X0,Y0,X1,Y1");
  app->add_option("--camera", o.camera, "camera of the file, by name or index [the first]")
      ->type_name("NAME|INDEX");
  CLI::Option* from = add_vector(app, "--look-from", o.look_from, "view from here instead");
  CLI::Option* at = add_vector(app, "--look-at", o.look_at, "towards this point");
  from->needs(at);
  at->needs(from);
  add_number(app, "--fov-y", o.fov_y, 0.05, 179.9,
             "vertical field of view in degrees [the camera's, or 40]");
  add_number(app, "--f-stop", o.f_stop, 1.0 / kMostOfLens, kMostOfLens,
             "f-number of a lens, for film 24 mm high [a pinhole: all is sharp]");
  add_number(app, "--focus-distance", o.focus_distance, 1.0 / kFarthest, kFarthest,
             "metres along the view to what is sharp [that of --look-at]");
}

void add_loading_options(CLI::App* app, bool& lenient, std::string& resource_root) {
  app->add_flag("--lenient", lenient,
                "take images that are cut short, replace those that do not decode; with warnings");
  app->add_option("--resource-root", resource_root,
                  "the scene may refer to files in this folder and below [its own folder]")
      ->type_name("DIR");
}

void add_light_options(CLI::App* app, RenderOptions& o) {
  CLI::Option* env = app->add_option("--env", o.environment, "latitude-longitude environment map")
                         ->type_name("FILE");
  add_number(app, "--env-strength", o.environment_strength, 0.0f, 1e9f,
             "multiplies the environment [1]")
      ->needs(env);
  add_number(app, "--env-rotation", o.environment_rotation, -36000.0f, 36000.0f,
             "degrees; 90 brings what was at +X to -Z [0]")
      ->needs(env);
  app->add_flag("--transparent", o.transparent, "the camera does not see the environment");
  app->add_option_function<std::string>(
         "--backfaces",
         [&o](const std::string& text) {
           if (text != "show" && text != "cull") {
             throw CLI::ValidationError("--backfaces",
                                        unknown_word_message("treatment", text, {"cull", "show"}));
           }
           o.show_backfaces = text == "show";
         },
         "single-sided faces seen from behind: cull (as glTF says) or show [cull]")
      ->type_name("cull|show");
  add_loading_options(app, o.lenient, o.resource_root);
}

void add_limits(CLI::App* app, LimitOptions& o) {
  app->add_option_function<std::string>(
         "--memory-limit",
         [&o](const std::string& text) {
           o.memory_bytes = parse_size(text);
           if (!o.memory_bytes) {
             throw CLI::ValidationError("--memory-limit",
                                        "'" + text + "' is not a size, such as 8G, 500M or 4096");
           }
         },
         "turn away what needs more memory: bytes, or with K, M, G, T powers of 1024 of them "
         "[three quarters of what the machine or its container has]")
      ->type_name("SIZE");
  add_number(app, "--load-timeout", o.load_timeout_s, kLeastTimeLimit, kMostTimeLimit,
             "give up loading and building after so many seconds [never]");
}

// What every render has, whoever decides where its samples go.
void add_integration_options(CLI::App* app, RenderOptions& o) {
  add_name(app, "--integrator", o.integrator, "integrator", "integrator [path]",
           integrator_table());
  add_number(app, "--max-depth", o.max_depth, 0, 100000,
             "scattering events; 1 is direct light only [16]");
  add_name(app, "--filter", o.filter, "filter",
           fmt::format("pixel filter [{}]", kDefaultFilter).c_str(), filter_table());
  add_number(app, "--filter-radius", o.filter_radius, 0.01f, PixelFilter::kMaxRadius,
             "in pixels [the filter's]");
  add_number(app, "--seed", o.seed, 0u, 0xffffffffu, "another seed, another noise [0]");
  add_number(app, "--bucket-size", o.bucket_size, 1, 4096, "in pixels [64]");
  add_name(app, "--bucket-order", o.bucket_order, "order", "order of the buckets [hilbert]",
           bucket_order_table());
  add_name(app, "--bisection-axis", o.bisection_axis, "axis",
           "what --driver bisection halves [both]", bisection_axis_table());
  add_name(app, "--reconstruction", o.reconstruction, "reconstruction",
           "what pixels without samples show, of progressive drivers [duplicate]",
           reconstruction_table());
  add_number(app, "--threads", o.threads, 1, 4096, "worker threads [all]");
  add_limits(app, o.limits);
}

void add_sampling_options(CLI::App* app, RenderOptions& o) {
  add_name(app, "--sampler", o.sampler, "sampler", "sampler [sobol]", sampler_table());
  add_number(app, "--streams", o.streams, 1, 2,
             "independent sample streams per pixel: 1, or 2 for honest half images [1, or what the "
             "estimator needs]");
  add_number(app, "--spp", o.spp, 1u, kMaxSamples,
             "samples per pixel; with adaptive sampling on average [64, or no limit where a "
             "threshold or --max-spp is given]");
  add_number(app, "--noise-threshold", o.noise_threshold, 1e-6f, 1.0f,
             "a pixel is finished when its expected RMS error in the displayed picture (0 to 1, "
             "sRGB) is at most this: 0.02 shows noise, 0.005 hardly any, 0.002 is half a step of "
             "8 bits");
  add_number(app, "--min-spp", o.min_spp, 1u, kMaxSamples,
             "samples before a pixel may be finished [the estimator's]");
  add_number(app, "--max-spp", o.max_spp, 1u, kMaxSamples,
             "most samples of any pixel [4096 with a threshold and no --spp]");
  // Looked up here, as an empty name would mean later that none was given.
  app->add_option_function<std::string>(
         "--estimator", [&o](const std::string& name) { o.estimator = find_estimator(name).name; },
         table_help(fmt::format("error estimator [{}]", kDefaultEstimator).c_str(),
                    estimator_table()))
      ->type_name("NAME");
  app->add_option_function<std::string>(
         "--allocation",
         [&o](const std::string& name) {
           parse_error_metric(name);
           o.allocation = name;
         },
         table_help("error to be least for the time spent [display]", error_metric_table()))
      ->type_name("NAME");
  app->add_flag("--unbiased", o.unbiased,
                "weigh rounds by plan, not by luck: no bias from adaptive stopping, more noise");
  add_number(app, "--time-limit", o.time_limit_s, kLeastTimeLimit, kMostTimeLimit,
             "stop rendering after so many seconds and write what there is [none]");
}

void add_edits(CLI::App* app, RenderOptions& o) {
  app->add_option("--edits", o.edits,
                  "change view, lights, environment and materials as this .json file says; its "
                  "view gives way to --camera, --look-from and --fov-y")
      ->type_name("FILE");
}

void add_variant(CLI::App* app, RenderOptions& o) {
  app->add_option("--variant", o.variant,
                  "materials of this variant, by name or index [the file's default]")
      ->type_name("NAME|INDEX");
}

// Of a heatmap's picture; on `render` they need a heatmap.
void add_heatmap_style(CLI::App* app, HeatmapStyle& style, CLI::Option* needed) {
  const auto bind = [needed](CLI::Option* option) {
    if (needed) option->needs(needed);
  };
  bind(app->add_option_function<std::string>(
              "--colors",
              [&style](const std::string& name) { style.colours = parse_colour_map(name); },
              table_help("colours of a heatmap [grey]", colour_map_table()))
           ->type_name("NAME"));
  bind(app->add_option_function<std::string>(
              "--range",
              [&style](const std::string& text) {
                std::array<double, 2> v;
                if (!parse_numbers(text, ',', v) || !is_value_range(v[0], v[1])) {
                  throw CLI::ValidationError(
                      "--range", "'" + text +
                                     "' is not MIN,MAX with MIN less than MAX by a millionth at "
                                     "least, from -1e18 to 1e18");
                }
                style.range = ValueRange{v[0], v[1]};
              },
              "values at the ends of a heatmap's colours; times in seconds [0 to what the "
              "greatest 2 % of the values above 0 exceed]")
           ->type_name("MIN,MAX"));
  bind(app->add_flag("--log", style.logarithmic, "logarithmic scale for a heatmap"));
  bind(app->add_flag("--plain", style.plain, "a heatmap without its legend"));
}

void add_heatmaps(CLI::App* app, RenderOptions& o) {
  CLI::Option* heatmap =
      app->add_option("--heatmap", o.heatmaps,
                      "where the samples went, as a picture with legend: .png, .jpg; .exr: the "
                      "numbers alone. May be given more than once")
          ->type_name("FILE")
          ->allow_extra_args(false);
  app->add_option(
         "--heatmap-of", o.heatmap_of,
         table_help("what it shows, the n-th for the n-th [samples]", heatmap_quantity_table()))
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->needs(heatmap);
  add_heatmap_style(app, o.heatmap_style, heatmap);
}

void add_grading(CLI::App* app, DisplaySettings& o) {
  app->add_option("--view", o.view, "OpenColorIO view [the display's default]");
  app->add_option("--look", o.look, "OpenColorIO look [none]");
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f, "stops, for .png and .jpg [0]");
}

void add_result_options(CLI::App* app, RenderOptions& o) {
  app->add_option("-o,--output", o.outputs,
                  "picture: .exr linear with all channels, streamed; .png, .jpg through "
                  "OpenColorIO, held in memory until done. May be given more than once")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app->add_option("--aov", o.aovs, table_help("further EXR channels, a list", aov_table()))
      ->type_name("LIST")
      ->join(',')  // --aov albedo --aov N: both
      ->check([](const std::string& list) {
        return list.empty() ? "needs a value, and the one given is empty: --aov LIST" : "";
      });
  app->add_flag("--light-groups", o.light_groups,
                "a layer light.NAME of the EXR for each light, emissive material and the "
                "environment: what it gives alone. They add up to R G B");
  add_heatmaps(app, o);
  app->add_option("--report", o.reports,
                  "what was done: .html is a page with pictures and charts, any other name JSON. "
                  "May be given more than once")
      ->type_name("FILE")
      ->allow_extra_args(false);
  CLI::Option* snapshots =
      app->add_option("--snapshots", o.snapshots,
                      "progressive drivers: keep the picture at several moments of the render in "
                      "this folder, and all of them as refinement.gif; a copy of each (16 bytes a "
                      "pixel) is held in memory until the frame is done")
          ->type_name("DIR");
  app->add_option("--snapshot-at", o.snapshot_at,
                  fmt::format("when: a list of 'first', N% of the pixels having a sample, Ns of "
                              "rendering, Nspp on average [{}]",
                              kDefaultSnapshotMoments))
      ->type_name("LIST")
      ->needs(snapshots);
  add_name(app, "--snapshot-format", o.snapshot_format, "format", "what is written of each [png]",
           snapshot_format_table())
      ->needs(snapshots);
  app->add_option("--reference", o.reference,
                  "measure each snapshot against this picture, into the report")
      ->type_name("FILE")
      ->needs(snapshots);
  app->add_option("--replay", o.replay, "compute one sample alone and print it")
      ->type_name("X,Y,SAMPLE");
  app->add_option_function<std::string>(
         "--explain",
         [&o](const std::string& text) {
           std::array<int, 2> v;
           if (!parse_numbers(text, ',', v) || v[0] < 0 || v[1] < 0) {
             throw CLI::ValidationError("--explain",
                                        "'" + text + "' is not X,Y in whole pixels of the frame");
           }
           o.explained = Vec2i(v[0], v[1]);
         },
         "after an adaptive render, print what decided this pixel's samples")
      ->type_name("X,Y");
  app->add_option("--tree", o.trees,
                  "the adaptive driver's refinement tree: leaves drawn over the picture (.png, "
                  ".jpg), or .json. May be given more than once")
      ->type_name("FILE")
      ->allow_extra_args(false);
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
  add_grading(app, o.display);
}

// What the window itself is told, beside the render in it.
void add_window_options(CLI::App* app, ViewOptions& o) {
  app->add_option("--window", "size of the window [as last time]")
      ->type_name("WxH")
      ->each([&o](const std::string& text) {
        std::array<int, 2> v;
        if (!parse_numbers(text, 'x', v) || v[0] < 320 || v[1] < 240 || v[0] > 16384 ||
            v[1] > 16384) {
          throw CLI::ValidationError("--window", "'" + text + "' is not WxH from 320x240 on");
        }
        o.window_size = Vec2i(v[0], v[1]);
      });
  add_number(app, "--ui-scale", o.interface_scale, 0.5f, 4.0f,
             "size of letters and panels [the screen's]");
  CLI::Option* screenshot =
      app->add_option("--screenshot", o.screenshot,
                      "write a picture of the window when the frame is done, and close")
          ->type_name("FILE");
  add_number(app, "--screenshot-after", o.screenshot_after_s, 0.001, 1e6,
             "not when the frame is done, but so many seconds after its first pass")
      ->needs(screenshot);
  CLI::Option* measure =
      app->add_option("--measure", o.measure,
                      "play edits, write how long each took to be on the screen, and close")
          ->type_name("FILE")
          ->excludes(screenshot);
  app->add_option("--measure-script", o.measure_script,
                  "the edits, a .json file [orbits, lights, materials and environment in turn]")
      ->type_name("FILE")
      ->needs(measure);
  app->add_option("--journal", o.journal, "what the window does, a line of JSON each")
      ->type_name("FILE");
  app->add_flag("--forget", o.forget,
                "neither read nor write the size and the panels of the window");
}

void add_study_choices(CLI::App* app, StudyOptions& o) {
  app->add_option("scene", o.frame.scene, "a .gltf or .glb file");
  app->add_option("-o,--output", o.folder, "folder of the results; it is made if it is not there")
      ->type_name("DIR");
  app->add_option("--drivers", o.drivers,
                  table_help("frame drivers, a list [bucket,bisection,adaptive]", driver_table()))
      ->type_name("LIST");
  app->add_option("--estimators", o.estimators,
                  table_help(fmt::format("of the adaptive driver, a list of "
                                         "ESTIMATOR[/ALLOCATION][/unbiased] [{}]",
                                         kDefaultEstimator)
                                 .c_str(),
                             estimator_table()))
      ->type_name("LIST");
  app->add_option("--samplers", o.samplers,
                  table_help("samplers, a list [sobol; of --convergence all]", sampler_table()))
      ->type_name("LIST");
  app->add_option("--spp", o.spp,
                  "budgets: samples per pixel on average, ascending [1,2,4,8,16,32,64]")
      ->type_name("LIST");
  app->add_option("--seconds", o.seconds, "budgets: seconds of rendering instead, ascending")
      ->type_name("LIST");
  add_number(app, "--seeds", o.seeds, 1u, 10000u,
             "runs of each method, from --seed on [5]; of --convergence pixels [2000]");
  app->add_option("--baseline", o.baseline, "the method that others are compared with [the first]")
      ->type_name("NAME");
  app->add_flag("--separate", o.separate,
                "render a frame of its own for every budget, also where one frame could be looked "
                "at on its way");
  CLI::Option* reference =
      app->add_option("--reference", o.reference,
                      "the true picture [one is rendered, in two halves, so that its own noise is "
                      "taken out]")
          ->type_name("FILE");
  add_number(app, "--reference-spp", o.reference_spp, 2u, kMaxSamples,
             "samples per pixel of the rendered reference [64 times the largest budget's]")
      ->excludes(reference);
  app->add_option("--cache", o.cache, "keep rendered references in this folder [DIR/reference]")
      ->type_name("DIR")
      ->excludes(reference);
  app->add_flag("--restart", o.restart, "forget the runs that the folder has");
  app->add_flag("--convergence", o.convergence,
                "no scene: variance against number of samples, on integrals with known values");
}

}  // namespace

void add_render_options(CLI::App* app, RenderOptions& o) {
  app->add_option("scene", o.scene, "a .gltf or .glb file")->required();
  add_edits(app, o);
  add_variant(app, o);
  add_result_options(app, o);
  add_name(app, "--driver", o.driver, "driver", "frame driver [bucket]", driver_table());
  add_sampling_options(app, o);
  add_integration_options(app, o);
  add_frame_options(app, o);
  add_light_options(app, o);
}

void add_view_options(CLI::App* app, ViewOptions& o) {
  RenderOptions& r = o.render;
  r.driver = kLiveDriver;
  app->add_option("scene", r.scene, "a .gltf or .glb file [one is opened in the window]");
  add_edits(app, r);
  add_window_options(app, o);
  add_variant(app, r);
  std::vector<NamedDriver> drivers = {
      {kLiveDriver, "bisection until every pixel has a sample, then adaptive"}};
  for (const DriverEntry& entry : driver_table()) drivers.push_back({entry.name, entry.summary});
  add_name(app, "--driver", r.driver, "driver", "frame driver [live]", drivers);
  add_sampling_options(app, r);
  add_integration_options(app, r);
  add_frame_options(app, r);
  add_light_options(app, r);
  app->add_flag("--light-groups", r.light_groups,
                "keep what each light gives apart: changes of lights then need no new ray");
  app->add_option("--display", r.display.display, "OpenColorIO display [the config's default]")
      ->type_name("NAME");
  add_grading(app, r.display);
}

void add_info_options(CLI::App* app, InfoOptions& o) {
  app->add_option("scene", o.scene, "a .gltf or .glb file")->required();
  app->add_flag("--json", o.json, "machine-readable");
  add_loading_options(app, o.lenient, o.resource_root);
  add_limits(app, o.limits);
}

void add_heatmap_options(CLI::App* app, HeatmapOptions& o) {
  o.quantity = heatmap_quantity_table().front().name;
  app->add_option("image", o.image, "an .exr that render wrote")->required();
  app->add_option("-o,--output", o.output,
                  "picture with legend: .png, .jpg; .exr: the numbers alone")
      ->type_name("FILE")
      ->required();
  app->add_option("--of", o.quantity,
                  table_help("what it shows [samples]", heatmap_quantity_table()))
      ->type_name("NAME");
  add_heatmap_style(app, o.style, nullptr);
  add_limits(app, o.limits);
}

void add_compare_options(CLI::App* app, CompareOptions& o) {
  app->add_option("image", o.image, "the image")->required();
  app->add_option("reference", o.reference, "what it should be")->required();
  app->add_flag("--json", o.json, "machine-readable");
  app->add_option("-o,--difference", o.difference,
                  "difference picture: FLIP as .png, signed difference as .exr");
  add_number(app, "--exposure", o.exposure, -64.0f, 64.0f, "stops, for FLIP, SSIM and PSNR [0]");
  add_limits(app, o.limits);
}

void add_study_options(CLI::App* app, StudyOptions& o) {
  o.frame.width = 320;
  o.frame.height = 180;
  add_study_choices(app, o);
  add_integration_options(app, o.frame);
  add_frame_options(app, o.frame);
  add_light_options(app, o.frame);
}

}  // namespace emberline
