// `extend`: adds samples to a finished frame whose checkpoint was kept.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/engine/frame_settings.h"
#include "renderer/output/recorded_settings.h"

namespace emberline {

// Returns the settings in a checkpoint's head, including the paths of the input files. Throws an
// InputError that names `path`, the path of the checkpoint.
FrameSettings stored_settings(const nlohmann::json& head, const std::string& path);

// Applies `spp`, `noise-threshold`, `max-spp` and `time-limit` of `more` to `settings`. Throws
// InputError if the frame cannot be extended. Throws UsageError if `more` sets none of `spp`,
// `noise-threshold` and `max-spp`, sets a limit that the frame does not have, or sets one that
// would stop the frame earlier than its present limit.
void extend_settings(const FrameSettings& more, const std::string& path, FrameSettings& settings);

// Returns the path of the checkpoint that --resumable keeps beside a picture.
std::string checkpoint_beside(const std::string& picture);

// Throws an InputError that names `path` if frames with these settings cannot be extended.
void check_extensible(const FrameSettings& settings, const std::string& path);

// Says why this checkpoint cannot be used to extend the frame whose picture records these settings.
// Returns "" if it can be used. Compares only the settings.
std::string extension_obstacle(const std::string& checkpoint, const RecordedSettings& picture);

}  // namespace emberline
