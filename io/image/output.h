// Writes 8-bit pictures: PNG, JPEG, and animated GIF.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/byte_image.h"

namespace emberline {

// Rounds a display value to the nearest of 256 steps. Clamps to [0, 1]; NaN becomes 0.
inline uint8_t to_byte(float value) {
  if (!(value > 0.0f)) return 0;
  return value >= 1.0f ? 255 : uint8_t(value * 255.0f + 0.5f);
}

// Returns "png" or "jpeg", depending on the suffix of `path` (case does not matter). Throws
// UsageError, which lists the valid suffixes.
std::string image_format_of(const std::string& path);

// Encodes a file in this format. The result is deterministic. JPEG drops alpha, and uses quality 95
// without chroma subsampling. Throws a RenderError that names `path`.
std::vector<unsigned char> encode_image(const ByteImage& image, const std::string& format,
                                        const std::string& path);

// Encodes a GIF that repeats endlessly. The frames must have three channels and the same size. Each
// frame gets its own palette of 256 colours. `frame_s` is rounded to hundredths of a second. Throws
// a RenderError that names `path`.
std::vector<unsigned char> encode_animation(std::span<const ByteImage> frames, double frame_s,
                                            const std::string& path);

// Encodes the image in the format that the suffix of `path` states, and writes the file atomically.
// Throws UsageError and RenderError.
void write_image(const std::string& path, const ByteImage& image);

}  // namespace emberline
