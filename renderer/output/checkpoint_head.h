// What a checkpoint says of its frame: all that its bits depend on, to be compared; where its files
// were, and which machine it is of, to be told.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"
#include "renderer/drivers/frame_plan.h"
#include "renderer/output/render_options.h"

namespace emberline {

// `plan` has the channels that are rendered. Reads all files of the scene. Throws what loading them
// throws.
nlohmann::ordered_json checkpoint_head(const RenderOptions& options, const FramePlan& plan,
                                       LoadProgress& progress);

// What keeps a frame of `now` from going on with a checkpoint of `then`, a few words each; nothing
// if its bits are the same. Anything may stand in `then`.
std::vector<std::string> differences(const nlohmann::ordered_json& now,
                                     const nlohmann::ordered_json& then);
// The same of machine and libraries: bits may differ by rounding between kinds of processor.
std::vector<std::string> machine_differences(const nlohmann::ordered_json& now,
                                             const nlohmann::ordered_json& then);

}  // namespace emberline
