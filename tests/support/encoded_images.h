// Encodes images for tests with OpenImageIO.
#pragma once

#include <OpenImageIO/imageio.h>

#include <stdexcept>

#include "support/temp_folder.h"

namespace emberline::test {

// Writes an image to `path`, whose suffix decides the format. `texels` are interleaved, in rows
// from the top. `spec` contains the size, channels, type and attributes.
template <class T>
void write_image(const std::string& path, const OIIO::ImageSpec& spec,
                 const std::vector<T>& texels) {
  const auto type = OIIO::TypeDesc(OIIO::TypeDesc::BASETYPE(OIIO::BaseTypeFromC<T>::value));
  auto output = OIIO::ImageOutput::create(path);
  if (!output || !output->open(path, spec) || !output->write_image(type, texels.data()) ||
      !output->close()) {
    throw std::runtime_error("cannot write " + path);
  }
}

// Returns the bytes of such a file. `suffix` is "png", "jpg", "webp", "exr" or "hdr".
template <class T>
std::vector<uint8_t> encode_image(const std::string& suffix, const OIIO::ImageSpec& spec,
                                  const std::vector<T>& texels) {
  const TempFolder folder;
  const std::string path = folder / ("image." + suffix);
  write_image(path, spec, texels);
  return read_bytes(path);
}

}  // namespace emberline::test
