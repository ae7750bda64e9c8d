#include "renderer/app/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "renderer/app/compare_command.h"
#include "renderer/app/info_command.h"
#include "renderer/app/render_command.h"
#include "renderer/app/report.h"
#include "renderer/app/version.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/drivers/bucket_driver.h"

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

// "a,b,c" -> numbers; every number finite and nothing left over.
template <typename T, size_t kCount>
bool parse_numbers(const std::string& text, char separator, std::array<T, kCount>& out) {
  const char* p = text.c_str();
  for (size_t i = 0; i < kCount; ++i) {
    char* end = nullptr;
    const double value = std::strtod(p, &end);
    if (end == p || !std::isfinite(value) || std::abs(value) > 1e15) return false;
    out[i] = T(value);
    if (double(out[i]) != value && std::is_integral_v<T>) return false;
    p = end;
    if (i + 1 < kCount && *p++ != separator) return false;
  }
  return *p == '\0';
}

CLI::Option* add_vector(CLI::App* app, const std::string& name, std::optional<Vec3d>& target,
                        const std::string& help) {
  return app->add_option_function<std::string>(
                name,
                [&target, name](const std::string& text) {
                  std::array<double, 3> v;
                  if (!parse_numbers(text, ',', v)) {
                    throw CLI::ValidationError(name, "'" + text + "' is not X,Y,Z");
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
         "frame in pixels [1280x720]")
      ->type_name("WxH");
  app->add_option_function<std::string>(
         "--crop",
         [&o](const std::string& text) {
           std::array<int, 4> v;
           if (!parse_numbers(text, ',', v)) {
             throw CLI::ValidationError("--crop", "'" + text + "' is not X0,Y0,X1,Y1");
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
  app->add_option("--fov-y", o.fov_y, "vertical field of view in degrees [the camera's, or 40]")
      ->type_name("DEG")
      ->check(CLI::Range(1e-3, 179.9));
}

void add_light_options(CLI::App* app, RenderOptions& o) {
  CLI::Option* env = app->add_option("--env", o.environment, "latitude-longitude environment map")
                         ->type_name("FILE");
  app->add_option("--env-strength", o.environment_strength, "multiplies the environment [1]")
      ->check(CLI::Range(0.0f, 1e12f))
      ->needs(env);
  app->add_option("--env-rotation", o.environment_rotation,
                  "degrees; 90 brings what was at +X to -Z [0]")
      ->type_name("DEG")
      ->check(CLI::Range(-36000.0f, 36000.0f))
      ->needs(env);
  app->add_flag("--transparent", o.transparent, "the camera does not see the environment");
  app->add_option_function<std::string>(
         "--backfaces",
         [&o](const std::string& text) { o.show_backfaces = text == "show"; },
         "single-sided faces seen from behind: cull (as glTF says) or show [cull]")
      ->type_name("cull|show")
      ->check(CLI::IsMember({"cull", "show"}));
  app->add_flag("--lenient", o.lenient, "replace images that do not decode, with a warning");
}

void add_sampling_options(CLI::App* app, RenderOptions& o) {
  app->add_option("--driver", o.driver, table_help("frame driver [bucket]", driver_table()))
      ->type_name("NAME");
  app->add_option("--integrator", o.integrator,
                  table_help("integrator [path]", integrator_table()))
      ->type_name("NAME");
  app->add_option("--sampler", o.sampler, table_help("sampler [sobol]", sampler_table()))
      ->type_name("NAME");
  app->add_option("--streams", o.streams,
                  "independent sample streams per pixel: 1, or 2 for honest half images [1]")
      ->check(CLI::Range(1, 2));
  app->add_option("--spp", o.spp, "samples per pixel [64]")->check(CLI::Range(1, 1 << 24));
  app->add_option("--max-depth", o.max_depth, "scattering events; 1 is direct light only [16]")
      ->check(CLI::Range(0, 100000));
  app->add_option("--filter", o.filter,
                  table_help(fmt::format("pixel filter [{}]", kDefaultFilter).c_str(),
                             filter_table()))
      ->type_name("NAME");
  app->add_option("--filter-radius", o.filter_radius, "in pixels [the filter's]")
      ->check(CLI::Range(0.01f, PixelFilter::kMaxRadius));
  app->add_option("--seed", o.seed, "another seed, another noise [0]");
  app->add_option("--bucket-size", o.bucket_size, "in pixels [64]")->check(CLI::Range(1, 4096));
  app->add_option("--bucket-order", o.bucket_order,
                  table_help("order of the buckets [hilbert]", bucket_order_table()))
      ->type_name("NAME");
  app->add_option("--threads", o.threads, "worker threads [all]")->check(CLI::Range(1, 4096));
}

void add_result_options(CLI::App* app, RenderOptions& o) {
  app->add_option("-o,--output", o.outputs,
                  "picture: .exr linear with all channels; .png, .jpg through OpenColorIO. May be "
                  "given more than once")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app->add_option("--aov", o.aovs, table_help("further EXR channels, a list", aov_table()))
      ->type_name("LIST");
  app->add_option("--report", o.report, "write what was done, as JSON")->type_name("FILE");
  app->add_option("--replay", o.replay, "compute one sample alone and print it")
      ->type_name("X,Y,SAMPLE");
  app->add_option("--display", o.display.display, "OpenColorIO display [the config's default]");
  app->add_option("--view", o.display.view, "OpenColorIO view [the display's default]");
  app->add_option("--look", o.display.look, "OpenColorIO look [none]");
  app->add_option("--exposure", o.display.exposure, "stops, for .png and .jpg [0]")
      ->check(CLI::Range(-64.0f, 64.0f));
}

// The valid options of a subcommand, for the message about an unknown one.
std::string option_names(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    if (!name.starts_with("-")) continue;
    text += (text.empty() ? "" : " ") + name;
  }
  return text;
}

[[noreturn]] void throw_usage(const CLI::App& root, const CLI::ParseError& error) {
  const CLI::App* app = &root;
  for (const CLI::App* sub : root.get_subcommands()) app = sub;
  std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !app->remaining().empty()) {
    const std::string unknown = app->remaining().front();
    if (unknown.starts_with("-")) {
      message = "unknown option '" + unknown + "'; valid options are " + option_names(*app);
    } else if (app == &root) {
      message = "unknown command '" + unknown + "'; valid commands are render, compare, info";
    } else {
      message = "unexpected argument '" + unknown + "'";
    }
  }
  throw UsageError(message);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App root("Emberline: a path tracer for glTF scenes", "emberline");
  root.require_subcommand(0, 1);
  bool version = false;
  root.add_flag("--version", version, "print the versions of the program and its libraries");

  bool quiet = false, verbose = false;
  const auto add_log_flags = [&](CLI::App* app) {
    CLI::Option* q = app->add_flag("--quiet", quiet, "errors only");
    app->add_flag("--verbose", verbose, "say what is built and why")->excludes(q);
  };

  RenderOptions render;
  CLI::App* render_app = root.add_subcommand("render", "render a scene to pictures");
  render_app->add_option("scene", render.scene, "a .gltf or .glb file")->required();
  add_result_options(render_app, render);
  add_sampling_options(render_app, render);
  add_frame_options(render_app, render);
  add_light_options(render_app, render);
  add_log_flags(render_app);

  InfoOptions info;
  CLI::App* info_app = root.add_subcommand("info", "what is in a scene and what becomes of it");
  info_app->add_option("scene", info.scene, "a .gltf or .glb file")->required();
  info_app->add_flag("--json", info.json, "machine-readable");
  info_app->add_flag("--lenient", info.lenient, "replace images that do not decode");
  add_log_flags(info_app);

  CompareOptions compare;
  CLI::App* compare_app = root.add_subcommand("compare", "measure an image against a reference");
  compare_app->add_option("image", compare.image, "the image")->required();
  compare_app->add_option("reference", compare.reference, "what it should be")->required();
  compare_app->add_flag("--json", compare.json, "machine-readable");
  compare_app->add_option("-o,--difference", compare.difference,
                          "difference picture: FLIP as .png, signed difference as .exr");
  compare_app->add_option("--exposure", compare.exposure, "stops, for FLIP, SSIM and PSNR [0]")
      ->check(CLI::Range(-64.0f, 64.0f));
  add_log_flags(compare_app);

  try {
    root.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return root.exit(success);  // --help
  } catch (const CLI::ParseError& error) {
    throw_usage(root, error);
  }
  set_log_level(quiet ? LogLevel::kQuiet : verbose ? LogLevel::kVerbose : LogLevel::kNormal);
  for (int i = 0; i < argc; ++i) {
    render.command_line += (i ? " " : "") + std::string(i ? argv[i] : "emberline");
  }

  if (version) {
    for (const auto& [name, number] : library_versions()) fmt::print("{} {}\n", name, number);
    return kExitDone;
  }
  if (render_app->parsed()) {
    if (render.outputs.empty() && !render.replay) {
      throw UsageError("render needs an output: -o FILE.exr (or .png, .jpg)");
    }
    if (render.filter.empty()) render.filter = kDefaultFilter;
    return run_render(render);
  }
  if (info_app->parsed()) return run_info(info);
  if (compare_app->parsed()) return run_compare(compare);
  fmt::print("{}", root.help());
  return kExitUsage;
}

}  // namespace emberline
