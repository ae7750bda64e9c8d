#include "io/image/output.h"

#include <algorithm>
#include <cassert>
#include <string_view>

#include "io/files/atomic_file.h"
#include "io/image/codecs.h"
#include "io/image/library.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"

namespace emberline {
namespace {

void check_encoded(const std::string& error, const std::string& path) {
  if (!error.empty()) throw RenderError("cannot write {}: {}", path, error);
}

}  // namespace

std::string image_format_of(const std::string& path) {
  const std::string suffix = lower_suffix(path);
  if (suffix == ".png") return "png";
  if (suffix == ".jpg" || suffix == ".jpeg") return "jpeg";
  throw UsageError(
      "cannot tell the picture's format from \"{}\"; valid suffixes are .png, .jpg, .jpeg", path);
}

std::vector<unsigned char> encode_image(const ByteImage& image, const std::string& format,
                                        const std::string& path) {
  assert(image.values.size() ==
         size_t(image.width) * size_t(image.height) * size_t(image.channels));
  std::vector<unsigned char> encoded;
  check_encoded(format == "png" ? encode_png(image, encoded) : encode_jpeg(image, encoded), path);
  return encoded;
}

std::vector<unsigned char> encode_animation(std::span<const ByteImage> frames, double frame_s,
                                            const std::string& path) {
  assert(!frames.empty() && std::ranges::all_of(frames, [&](const ByteImage& frame) {
    return frame.width == frames[0].width && frame.height == frames[0].height &&
           frame.channels == 3;
  }));
  std::vector<unsigned char> encoded;
  check_encoded(image_library().encode_gif(frames, frame_s, encoded), path);
  return encoded;
}

void write_image(const std::string& path, const ByteImage& image) {
  const std::vector<unsigned char> bytes = encode_image(image, image_format_of(path), path);
  write_file_atomically(
      path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace emberline
