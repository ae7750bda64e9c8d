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

}  // namespace emberline
