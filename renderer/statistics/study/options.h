// The options of a study.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>

#include "renderer/engine/setting_table.h"
#include "renderer/output/render_options.h"

namespace emberline {

inline constexpr uint32_t kMostStudySeeds = 10000;

// The settings of a study's frames; what is compared is in the lists of StudyOptions.
inline constexpr std::initializer_list<SettingGroup> kStudySettings = {
    SettingGroup::kSample, SettingGroup::kSeed,  SettingGroup::kSchedule,
    SettingGroup::kView,   SettingGroup::kLight, SettingGroup::kLoading};

struct StudyOptions {
  RenderOptions frame;  // kStudySettings, the scene and what the machine gives
  // Lists, separated by commas. An estimator may have its allocation behind it and then `unbiased`:
  // "two-stream/mse", "two-stream/display/unbiased".
  std::string drivers = "bucket,bisection,adaptive";
  std::string estimators{kDefaultEstimator};
  std::optional<std::string> samplers;      // sobol; of --convergence all
  std::optional<std::string> spp, seconds;  // budgets; one of them at most
  std::optional<uint32_t> seeds;            // 5; of --convergence 2000
  std::string baseline;                     // a method's name; empty: bucket, or the first
  bool denoise = false;                     // each method again, with a denoised picture
  bool separate = false;                    // a run of its own for every budget
  std::string reference;                    // a picture; empty: one is rendered
  std::optional<uint32_t> reference_spp;
  std::string cache;   // folder of rendered references; empty: in the study's
  std::string folder;  // of the results
  bool restart = false;
  bool convergence = false;  // of the samples alone, without a scene
};

}  // namespace emberline
