// Lists the files of a scene, so that it can be copied.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"

namespace emberline {

// The .gltf or .glb file first, then every existing buffer and image file that it refers to, by the
// file's own names: absolute, links not followed, without duplicates. `resource_root` as in
// GltfOptions. Throws InputError for an unreadable scene.
std::vector<std::filesystem::path> scene_files(const std::string& path,
                                               const std::string& resource_root = {},
                                               LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
