// The settings that the pixels and times of a study depend on, as texts for the study's records and
// as keys for its files.
#pragma once

#include <string>

#include "renderer/core/load_progress.h"
#include "renderer/engine/setting_table.h"
#include "renderer/statistics/study/plan.h"

namespace emberline {

// Returns the settings of the view, light, integrator, filter and buckets, by option name. The
// settings have the names of input files, not their contents.
SettingTexts frame_settings(const RenderOptions& options);

// Returns a line of JSON with everything that a frame's pixels depend on, except the driver, the
// sampler, the number of samples and the seed. The line has the settings of frame_settings() except
// those of buckets (SettingGroup::kSchedule), and fingerprints of the input files instead of their
// names. Reads the files within the limits. Throws InputError.
std::string frame_key(const RenderOptions& options, const LoadLimits& limits);

// Returns the key of one half of the reference.
std::string reference_key(const std::string& frame_key, const RenderOptions& half);

// Returns the key of a study's runs. It contains everything that must not change when the study is
// resumed.
std::string study_key(const std::string& frame_key, const StudyOptions& options,
                      const StudyPlan& plan, const LoadLimits& limits);

}  // namespace emberline
