// Decodes buffer views of EXT_meshopt_compression and KHR_meshopt_compression.
#pragma once

#include "io/gltf/document/document.h"

namespace emberline {

// Decodes `encoded` to the `byte_length` bytes of the view at `place`. `extension` describes the
// encoding. Before allocating memory, checks that `encoded` can hold that much data, and reserves
// the memory from the budget of `progress`. Throws InputError.
std::vector<uint8_t> decode_meshopt_view(const nlohmann::json& extension, ByteSpan encoded,
                                         uint64_t byte_length, const std::string& place,
                                         const LoadProgress& progress = LoadProgress::none());

// The functions below (meshopt_v1.cpp) implement the parts of KHR_meshopt_compression that are
// neither in EXT_meshopt_compression nor in meshoptimizer 0.18: version 1 of the attribute codec
// and the COLOR filter (appendices A and B of the extension's specification).

// Whether the attribute stream has the header of version 1.
bool is_meshopt_v1(std::span<const uint8_t> encoded);

// Returns the minimum size in bytes of a stream of `count` elements (the size if all are zero).
uint64_t min_meshopt_v1_size(uint64_t count, uint64_t stride);

// Decodes `count` elements of `stride` bytes (a multiple of 4, at most 256) into `decoded`, which
// must have room for them. Returns false for an invalid stream. Never reads outside the stream.
bool decode_meshopt_v1(std::span<const uint8_t> encoded, size_t count, size_t stride,
                       uint8_t* decoded);

// Converts YCoCg and alpha to RGBA in place; `stride` is 4 (8-bit components) or 8 (16-bit).
void decode_meshopt_color(uint8_t* elements, size_t count, size_t stride);

}  // namespace emberline
