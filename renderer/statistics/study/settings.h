// The settings that pixels and times of a study depend on: for its records, and as keys of files.
#pragma once

#include <string>

#include "renderer/core/load_progress.h"
#include "renderer/engine/setting_table.h"
#include "renderer/statistics/study/plan.h"

namespace emberline {

// View, light, integrator, filter and buckets, by the names of the options; files by name.
SettingTexts frame_settings(const RenderOptions& options);

// A line of JSON with all that the pixels of a frame depend on but driver, sampler, samples and
// seed: the settings above, and what is in the files instead of their names. Reads the files,
// within the limits; throws InputError.
std::string frame_key(const RenderOptions& options, const LoadLimits& limits);

// The same of a half of the reference.
std::string reference_key(const std::string& frame_key, const RenderOptions& half);

// The same of the runs of a study: what must not change between a start and the next.
std::string study_key(const std::string& frame_key, const StudyOptions& options,
                      const StudyPlan& plan, const LoadLimits& limits);

}  // namespace emberline
