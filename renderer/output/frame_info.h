// `emberline info FRAME.exr`: what an EXR contains, how it was made, and whether it is finished.
#pragma once

#include <string>

#include "renderer/core/load_progress.h"

namespace emberline {

// Whether the file's contents, regardless of its name, are an EXR. Returns false if the file does
// not exist. Throws InputError if the file cannot be read.
bool is_exr_file(const std::string& path);

// Returns text, or JSON: {"file", "width", "height", "window", "working_space", "layers": [{"name",
// "channels": [{"name", "type"}]}], "unread_parts", "state", "command", "scene",
// "instruction_sets", "explanation", "settings", "versions"}. "state" has "complete" (null for a
// frame of another program), "samples" and "samples_per_pixel" (null if unknown), "checkpoint",
// "extensible" and "obstacle", which says why the frame is not extensible. "settings" has the
// settings that differ from the defaults.
//
// Reads no pixels. Throws InputError.
std::string frame_info(const std::string& path, const LoadProgress& progress, bool as_json);

}  // namespace emberline
