// The settings that the pixels and times of a study depend on, for its records and for the keys of
// its files.
#pragma once

#include <string>

#include "renderer/core/load_progress.h"
#include "renderer/engine/setting_table.h"
#include "renderer/statistics/study/plan.h"

namespace emberline {

// Settings of view, light, integrator, filter and buckets, by option name; files are given by name.
SettingTexts frame_settings(const RenderOptions& options);

// Returns a line of JSON with everything that a frame's pixels depend on, except driver, sampler,
// samples and seed: the settings above, with the contents of files instead of their names. Reads
// the files within the limits; throws InputError.
std::string frame_key(const RenderOptions& options, const LoadLimits& limits);

// The key of a half of the reference.
std::string reference_key(const std::string& frame_key, const RenderOptions& half);

// The key of a study's runs: what must not change when the study is resumed.
std::string study_key(const std::string& frame_key, const StudyOptions& options,
                      const StudyPlan& plan, const LoadLimits& limits);

}  // namespace emberline
