// What a file holds, in 64 bits: to tell whether a result that was kept belongs to it still. Not
// safe against someone who tries to deceive.
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

// Of the whole file. Throws InputError, and what `progress` says.
uint64_t file_fingerprint(const std::string& path,
                          const LoadProgress& progress = LoadProgress::unwatched());

// Of a .gltf or .glb file and of every buffer and image file that it names; one that is missing
// counts too (--lenient). `resource_root` as in GltfOptions. Throws InputError for a scene that
// cannot be read.
uint64_t scene_fingerprint(const std::string& path, const std::string& resource_root = {},
                           LoadProgress& progress = LoadProgress::unwatched());

}  // namespace emberline
