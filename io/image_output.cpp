#include "io/image_output.h"

#include <algorithm>
#include <cassert>
#include <filesystem>
#include <string_view>

#include "io/atomic_file.h"
#include "io/image_library.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"

namespace emberline {
namespace {

std::vector<unsigned char> encode(const std::string& format, std::span<const ByteImage> pictures,
                                  double picture_s, const std::string& path) {
  std::vector<unsigned char> encoded;
  const std::string error = image_library().encode(format, pictures, picture_s, encoded);
  if (!error.empty()) throw RenderError("cannot write " + path + ": " + error);
  return encoded;
}

}  // namespace

std::string image_format_of(const std::string& path) {
  const std::string suffix = lower_suffix(path);
  if (suffix == ".png") return "png";
  if (suffix == ".jpg" || suffix == ".jpeg") return "jpeg";
  throw UsageError("cannot tell the picture's format from \"" + path +
                   "\"; valid suffixes are .png, .jpg, .jpeg");
}

std::vector<unsigned char> encode_image(const ByteImage& image, const std::string& format,
                                        const std::string& path) {
  assert(image.values.size() ==
         size_t(image.width) * size_t(image.height) * size_t(image.channels));
  return encode(format, {&image, 1}, 0.0, path);
}

std::vector<unsigned char> encode_animation(std::span<const ByteImage> frames, double frame_s,
                                            const std::string& path) {
  assert(!frames.empty() && std::ranges::all_of(frames, [&](const ByteImage& frame) {
    return frame.width == frames[0].width && frame.height == frames[0].height &&
           frame.channels == 3;
  }));
  return encode("gif", frames, frame_s, path);
}

void write_image(const std::string& path, const ByteImage& image) {
  const std::vector<unsigned char> bytes = encode_image(image, image_format_of(path), path);
  write_file_atomically(
      path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace emberline
