// `extend`: adds samples to a finished frame whose checkpoint was kept.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/engine/frame_settings.h"

namespace emberline {

// Returns the settings in a checkpoint's head, including its input files. Throws InputError that
// names `path`, the checkpoint.
FrameSettings stored_settings(const nlohmann::json& head, const std::string& path);

// Applies `spp`, `noise-threshold`, `max-spp` and `time-limit` of `more`. Throws InputError for a
// frame that cannot be extended, UsageError for less than it has.
void extend_settings(const FrameSettings& more, const std::string& path, FrameSettings& settings);

// The checkpoint that --resumable keeps beside a picture.
std::string checkpoint_beside(const std::string& picture);

// Why the frame of this checkpoint cannot be extended, as far as its settings say; empty if it can.
std::string extension_obstacle(const std::string& checkpoint);

}  // namespace emberline
