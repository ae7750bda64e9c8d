// Writes 8-bit pictures: PNG, JPEG, and animated GIF.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/byte_image.h"

namespace emberline {

// Rounds a display value to the nearest of 256 steps; clamps to [0, 1], NaN becomes 0.
inline uint8_t to_byte(float value) {
  if (!(value > 0.0f)) return 0;
  return value >= 1.0f ? 255 : uint8_t(value * 255.0f + 0.5f);
}

// Returns "png" or "jpeg", from the suffix of `path` (case does not matter). Throws UsageError,
// which lists the valid suffixes.
std::string image_format_of(const std::string& path);

// Encodes a file in this format. The result is deterministic. JPEG drops alpha and uses quality 95
// without chroma subsampling. Throws RenderError naming `path`.
std::vector<unsigned char> encode_image(const ByteImage& image, const std::string& format,
                                        const std::string& path);

// Encodes an endlessly repeated GIF. The frames must have three channels and the same size; each
// gets its own palette of 256 colours. `frame_s` is rounded to hundredths of a second. Throws
// RenderError naming `path`.
std::vector<unsigned char> encode_animation(std::span<const ByteImage> frames, double frame_s,
                                            const std::string& path);

// Encodes the image in the format of the suffix and writes the file atomically. Throws UsageError
// and RenderError.
void write_image(const std::string& path, const ByteImage& image);

}  // namespace emberline
