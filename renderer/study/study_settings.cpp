#include "renderer/study/study_settings.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "io/fingerprint.h"
#include "renderer/core/version.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;
using Settings = std::vector<std::pair<std::string, std::string>>;

std::string point(const Vec3d& p) { return fmt::format("{},{},{}", p.x, p.y, p.z); }

// All but the names of files.
Settings settings_without_files(const RenderOptions& o) {
  Settings list = {{"size", fmt::format("{}x{}", o.width, o.height)},
                   {"integrator", o.integrator},
                   {"max-depth", std::to_string(o.max_depth)},
                   {"filter", o.filter}};
  const auto add = [&](const char* name, const std::string& value) {
    list.emplace_back(name, value);
  };
  if (o.filter_radius) add("filter-radius", fmt::format("{}", *o.filter_radius));
  if (o.crop) {
    add("crop", fmt::format("{},{},{},{}", o.crop->x0, o.crop->y0, o.crop->x1, o.crop->y1));
  }
  if (!o.camera.empty()) add("camera", o.camera);
  if (o.look_from) {
    add("look-from", point(*o.look_from));
    add("look-at", point(*o.look_at));
  }
  if (o.fov_y) add("fov-y", fmt::format("{}", *o.fov_y));
  if (o.f_stop) add("f-stop", fmt::format("{}", *o.f_stop));
  if (o.focus_distance) add("focus-distance", fmt::format("{}", *o.focus_distance));
  if (!o.environment.empty()) {
    add("env-strength", fmt::format("{}", o.environment_strength));
    add("env-rotation", fmt::format("{}", o.environment_rotation));
  }
  if (o.transparent) add("transparent", "yes");
  if (o.show_backfaces) add("backfaces", "show");
  if (o.lenient) add("lenient", "yes");
  return list;
}

Settings schedule_settings(const RenderOptions& o) {
  return {{"bucket-size", std::to_string(o.bucket_size)},
          {"bucket-order", o.bucket_order},
          {"bisection-axis", o.bisection_axis},
          {"reconstruction", o.reconstruction}};
}

Json as_json(const Settings& settings) {
  Json json = Json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

std::string line(const Json& json) {
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace

Settings frame_settings(const RenderOptions& options) {
  Settings list = settings_without_files(options);
  if (!options.environment.empty()) list.emplace_back("env", options.environment);
  for (auto& setting : schedule_settings(options)) list.push_back(std::move(setting));
  return list;
}

std::string frame_key(const RenderOptions& options, const LoadLimits& limits) {
  LoadProgress progress({}, {}, limits);
  Json json = as_json(settings_without_files(options));
  json["version"] = kEmberlineVersion;
  json["scene"] = hexadecimal(scene_fingerprint(options.scene, options.resource_root, progress));
  if (!options.environment.empty()) {
    json["env"] = hexadecimal(file_fingerprint(options.environment, progress));
  }
  return line(json);
}

std::string reference_key(const std::string& frame_key, const RenderOptions& half) {
  return line({{"frame", frame_key},
               {"driver", half.driver},
               {"sampler", half.sampler},
               {"spp", half.spp.value_or(0)},
               {"seed", half.seed}});
}

std::string study_key(const std::string& frame_key, const StudyOptions& options,
                      const StudyPlan& plan, const LoadLimits& limits) {
  Json json = {{"frame", frame_key},
               {"schedule", as_json(schedule_settings(options.frame))},
               {"by_time", plan.by_time},
               {"budgets", plan.budgets},
               {"separate", options.separate},
               {"threads", options.frame.threads},
               {"reference_sampler", plan.reference_sampler},
               {"reference_spp", options.reference_spp.value_or(0)}};
  if (!options.reference.empty()) {
    json["reference"] =
        hexadecimal(file_fingerprint(options.reference, LoadProgress({}, {}, limits)));
  }
  return line(json);
}

}  // namespace emberline
