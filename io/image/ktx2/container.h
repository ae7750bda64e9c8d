// A KTX 2 file taken apart: where its parts are and what they hold, before anything is decoded.
// Numbers of sections are those of the "KTX File Format Specification", version 2.0.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "renderer/core/errors.h"

namespace emberline::ktx2 {

using Bytes = std::span<const uint8_t>;

inline constexpr int kBlockSide = 4;  // pixels; of ETC1S and UASTC alike
inline constexpr size_t kBlockPixels = 16;
inline constexpr size_t kUastcBlockBytes = 16;
// Red, green, blue and alpha of each pixel, rows from the top.
using BlockPixels = std::array<std::array<uint8_t, 4>, kBlockPixels>;

// The one error of a file that is damaged. `what` continues "the KTX 2 ...".
[[noreturn]] inline void throw_damaged(const std::string& place, const std::string& what) {
  throw InputError(place, "the image does not decode: the KTX 2 " + what);
}

enum class Codec : uint8_t { kEtc1s, kUastc };

struct Container {
  int64_t width = 0, height = 0;  // of level 0, 1 at least
  Codec codec = Codec::kUastc;
  bool is_srgb = false;  // the transfer function; else linear
  bool is_zstd = false;  // UASTC's blocks are packed by Zstandard
  int channels = 0;      // of the picture: 1 red, 3, 4 with alpha
  // Which channel of a block (0 red to 3 alpha, or -1: zero) each of the picture's is. The second
  // slice of ETC1S is its alpha.
  std::array<int, 4> sources = {};
  bool has_second_slice = false;  // ETC1S
  int levels = 0;
  std::array<uint64_t, 32> level_bytes = {};  // of each level, all inside the file
  Bytes level;                                // level 0, as it is stored
  Bytes global_data;                          // of BasisLZ

  int64_t blocks_across() const { return (width + kBlockSide - 1) / kBlockSide; }
};

// Checks everything but the levels' data and the global data. The result refers to `file`. Throws
// InputError: for a damaged file, and for what is not among the pictures of KHR_texture_basisu
// (2D; ETC1S in BasisLZ, or UASTC plain or in Zstandard; straight alpha; rows from the top).
Container read_container(Bytes file, const std::string& place);

}  // namespace emberline::ktx2
