// EXT_meshopt_compression and KHR_meshopt_compression: buffer views that hold meshoptimizer's
// codecs.
#pragma once

#include "io/gltf/document/document.h"

namespace emberline {

// Decodes the view at `pointer` ("/bufferViews/3") described by `extension`; `encoded` are its
// compressed bytes, `byte_length` what the view must become. The size that is allocated has been
// held against the size of `encoded` and reserved from the memory budget of `progress` before.
// Throws InputError.
std::vector<uint8_t> decode_meshopt_view(const nlohmann::json& extension, ByteSpan encoded,
                                         uint64_t byte_length, const std::string& place,
                                         const LoadProgress& progress = LoadProgress::unwatched());

// The rest, in meshopt_v1.cpp: what KHR_meshopt_compression has beyond EXT_meshopt_compression, and
// the library here, of version 0.18, does not: version 1 of the attribute codec, and the filter
// COLOR. Appendices A and B of its specification.

// Whether the stream of attributes begins as one of version 1.
bool is_meshopt_v1(std::span<const uint8_t> encoded);

// The least number of bytes that can hold so many elements (a stream of zeros).
uint64_t least_meshopt_v1_size(uint64_t count, uint64_t stride);

// Decodes `count` elements of `stride` bytes (a multiple of 4, at most 256) into `decoded`, which
// has room for them. False for a stream that is not valid; nothing outside of it is read.
bool decode_meshopt_v1(std::span<const uint8_t> encoded, size_t count, size_t stride,
                       uint8_t* decoded);

// YCoCg and alpha to RGBA, in place; `stride` is 4 (8-bit components) or 8 (16-bit).
void decode_meshopt_color(uint8_t* elements, size_t count, size_t stride);

}  // namespace emberline
