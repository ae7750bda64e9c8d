// 8-bit pictures out: PNG, JPEG, and animated GIF.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/byte_image.h"

namespace emberline {

// A display value in [0, 1] as one of 256 steps, the nearest; clipped, NaN becomes 0.
inline uint8_t to_byte(float value) {
  if (!(value > 0.0f)) return 0;
  return value >= 1.0f ? 255 : uint8_t(value * 255.0f + 0.5f);
}

// "png" or "jpeg" by the suffix of `path` (upper and lower case are alike). Throws UsageError that
// lists the suffixes for any other.
std::string image_format_of(const std::string& path);

// The bytes of a file of that format; the same for the same image. JPEG drops alpha, at quality 95
// without chroma subsampling. Throws RenderError naming `path`.
std::vector<unsigned char> encode_image(const ByteImage& image, const std::string& format,
                                        const std::string& path);

// The bytes of an animated GIF, repeated for ever, of frames of equal size and three channels, each
// with its own 256 colours; `frame_s` seconds a frame, to the hundredth. Throws RenderError naming
// `path`.
std::vector<unsigned char> encode_animation(std::span<const ByteImage> frames, double frame_s,
                                            const std::string& path);

// encode_image into a file that appears whole or not at all. Throws UsageError, RenderError.
void write_image(const std::string& path, const ByteImage& image);

}  // namespace emberline
