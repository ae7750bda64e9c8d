// The options of a study.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>

#include "renderer/engine/setting_table.h"
#include "renderer/output/render_options.h"

namespace emberline {

inline constexpr uint32_t kMaxStudySeeds = 10000;

// The groups of settings that are the same for all frames of a study. The lists in StudyOptions
// choose the methods that are compared.
inline constexpr std::initializer_list<SettingGroup> kStudySettings = {
    SettingGroup::kSample, SettingGroup::kSeed,  SettingGroup::kSchedule, SettingGroup::kView,
    SettingGroup::kTurn,   SettingGroup::kLight, SettingGroup::kLoading};

struct StudyOptions {
  RenderOptions frame;  // settings in kStudySettings, the scene and the limits of the run
  // Comma-separated lists. An estimator may be followed by its allocation and by `unbiased` or
  // `planned`: "two-stream/mse", "two-stream/display/unbiased", "nested/planned".
  std::string drivers = "bucket,bisection,adaptive";
  std::string estimators{kDefaultEstimator};
  std::optional<std::string> samplers;      // default: sobol; with --convergence: all
  std::optional<std::string> spp, seconds;  // budgets; at most one of them
  std::optional<uint32_t> seeds;            // default: 5; with --convergence: 2000
  std::string baseline;                     // name of a method; empty: the first method
  bool denoise = false;                     // also run each method with denoised pictures
  bool separate = false;                    // render a separate frame for every budget
  bool motion = false;                      // save the motion to the next frame, for flicker
  std::string reference;                    // a picture; empty: render one
  std::optional<uint32_t> reference_spp;
  std::string cache;   // for rendered references; empty: the study's folder
  std::string folder;  // for the results
  bool restart = false;
  bool convergence = false;  // study samplers alone, without a scene
};

}  // namespace emberline
