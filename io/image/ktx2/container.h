// Parses a KTX 2 file without decoding anything. Section numbers refer to the "KTX File Format
// Specification", version 2.0.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "renderer/core/errors.h"

namespace emberline::ktx2 {

using Bytes = std::span<const uint8_t>;

inline constexpr int kBlockSide = 4;  // pixels, for both ETC1S and UASTC
inline constexpr size_t kBlockPixels = 16;
inline constexpr size_t kUastcBlockBytes = 16;
// The RGBA values of each pixel, with rows from the top.
using BlockPixels = std::array<std::array<uint8_t, 4>, kBlockPixels>;

// Throws the error for a damaged file. `what` completes the sentence "the KTX 2 ...".
[[noreturn]] inline void throw_damaged(const std::string& place, const std::string& what) {
  throw InputError(place, "cannot decode the image: the KTX 2 " + what);
}

enum class Codec : uint8_t { kEtc1s, kUastc };

struct Container {
  int64_t width = 0, height = 0;  // size of level 0, at least 1
  Codec codec = Codec::kUastc;
  bool is_srgb = false;  // transfer function: sRGB (true) or linear (false)
  bool is_zstd = false;  // whether UASTC blocks are compressed with Zstandard
  int channels = 0;      // 1 (red), 3, or 4 with alpha
  // For each channel of the image, the channel of a decoded block from which it comes: 0 (red) to 3
  // (alpha), or -1 for zero. For ETC1S, alpha comes from the second slice.
  std::array<int, 4> sources = {};
  bool has_second_slice = false;  // for ETC1S
  int levels = 0;
  std::array<uint64_t, 32> level_bytes = {};  // size of each level; all levels lie inside the file
  Bytes level;                                // level 0 as stored
  Bytes global_data;                          // for BasisLZ

  int64_t blocks_across() const { return (width + kBlockSide - 1) / kBlockSide; }
};

// Checks everything except the data of the levels and the global data. The result refers to `file`.
// Throws InputError for a damaged file, and for images that KHR_texture_basisu does not allow.
// Allowed are 2D images in ETC1S with BasisLZ, or in UASTC without supercompression or with
// Zstandard, with unassociated alpha and with rows from the top.
Container read_container(Bytes file, const std::string& place);

}  // namespace emberline::ktx2
