// `extend`: a finished frame whose checkpoint was kept gets more samples.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/engine/frame_settings.h"

namespace emberline {

// The settings in a checkpoint's head, with the files that it was made of. Throws InputError that
// names `path`, the checkpoint.
FrameSettings stored_settings(const nlohmann::json& head, const std::string& path);

// Sets what `more` has of `spp`, `noise-threshold`, `max-spp` and `time-limit`. Throws InputError
// for a frame that cannot go on, UsageError for less than it has.
void extend_settings(const FrameSettings& more, const std::string& path, FrameSettings& settings);

}  // namespace emberline
