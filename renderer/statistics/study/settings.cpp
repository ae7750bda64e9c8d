#include "renderer/statistics/study/settings.h"

#include <nlohmann/json.hpp>

#include "io/files/fingerprint.h"
#include "renderer/core/version.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

Json as_json(const SettingTexts& settings) {
  return Json::object_t(settings.begin(), settings.end());
}

std::string line(const Json& json) {
  return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace

SettingTexts frame_settings(const RenderOptions& options) {
  using enum SettingGroup;
  return setting_texts(options, {kSample, kView, kTurn, kLight, kLoading, kSchedule});
}

std::string frame_key(const RenderOptions& options, const LoadLimits& limits) {
  using enum SettingGroup;
  LoadProgress progress({}, {}, limits);
  Json json = as_json(setting_texts(options, {kSample, kView, kTurn, kLight, kLoading}, false));
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
               {"schedule", as_json(setting_texts(options.frame, {SettingGroup::kSchedule}))},
               {"by_time", plan.by_time},
               {"budgets", plan.budgets},
               {"separate", options.separate || options.denoise},
               {"threads", options.frame.threads},
               {"reference_sampler", plan.reference_sampler},
               {"reference_spp", options.reference_spp.value_or(0)}};
  if (plan.by_time) json["separate_frames"] = "time-budget";
  if (!options.reference.empty()) {
    json["reference"] =
        hexadecimal(file_fingerprint(options.reference, LoadProgress({}, {}, limits)));
  }
  return line(json);
}

}  // namespace emberline
