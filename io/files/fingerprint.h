// 64-bit hashes that tell whether a cached result still belongs to a file. The hashes are not
// cryptographic.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

uint64_t fingerprint(std::string_view bytes, uint64_t seed = 0);
uint64_t fingerprint(std::span<const float> values, uint64_t seed = 0);
std::string hexadecimal(uint64_t value);  // 16 digits

// Hashes the whole file. Throws InputError, and Cancelled if `progress` is cancelled.
uint64_t file_fingerprint(const std::string& path,
                          const LoadProgress& progress = LoadProgress::none());

// Hashes a .gltf or .glb file and every buffer and image file that it names. A missing file changes
// the hash too, since --lenient renders without it. `resource_root` means the same as in
// GltfOptions. Throws InputError for an unreadable scene.
uint64_t scene_fingerprint(const std::string& path, const std::string& resource_root = {},
                           LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
