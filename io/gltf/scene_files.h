// Lists the files of a scene, so that the scene can be copied.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderer/core/load_progress.h"

namespace emberline {

// Returns the .gltf or .glb file, and then every existing buffer and image file that it refers to.
// The paths are absolute and without duplicates. Symbolic links in them are not resolved.
// `resource_root` means the same as in GltfOptions. Throws InputError for an unreadable scene.
std::vector<std::filesystem::path> scene_files(const std::string& path,
                                               const std::string& resource_root = {},
                                               LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
