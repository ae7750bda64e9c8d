// Which files a scene is made of, so that it can be copied.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"

namespace emberline {

// The .gltf or .glb file first, then every buffer and image file that it names and that is there,
// by the names that it has for them: absolute, links not followed, each once. `resource_root` as in
// GltfOptions. Throws InputError for a scene that cannot be read.
std::vector<std::filesystem::path> scene_files(const std::string& path,
                                               const std::string& resource_root = {},
                                               LoadProgress& progress = LoadProgress::unwatched());

}  // namespace emberline
