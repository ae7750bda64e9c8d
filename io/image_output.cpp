#include "io/image_output.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cassert>
#include <filesystem>
#include <string_view>

#include "io/atomic_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"

namespace emberline {
namespace {

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

[[noreturn]] void throw_not_encoded(const OIIO::ImageOutput& output, const std::string& path) {
  const std::string reason = one_line(output.geterror());
  throw RenderError("cannot write " + path + ": " +
                    (reason.empty() ? "OpenImageIO could not encode it" : reason));
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
  const bool jpeg = format == "jpeg";
  // OpenImageIO drops what the format cannot hold: the strides below step over the alpha.
  const int stored = jpeg && image.channels == 4 ? 3 : image.channels;
  OIIO::ImageSpec spec(image.width, image.height, stored, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);  // as we give it; else it would be divided again
  if (image.srgb) spec.attribute("oiio:ColorSpace", "sRGB");
  if (jpeg) {
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");
  }

  std::vector<unsigned char> encoded;
  OIIO::Filesystem::IOVecOutput sink(encoded);
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
  if (!output)
    throw RenderError("cannot write " + path + ": OpenImageIO has no " + format + " writer");
  const bool done = output->set_ioproxy(&sink) && output->open("picture." + format, spec) &&
                    output->write_image(OIIO::TypeDesc::UINT8, image.values.data(),
                                        OIIO::stride_t(image.channels)) &&
                    output->close();
  if (!done) throw_not_encoded(*output, path);
  return encoded;
}

std::vector<unsigned char> encode_animation(std::span<const ByteImage> frames, double frame_s,
                                            const std::string& path) {
  assert(!frames.empty());
  OIIO::ImageSpec spec(frames[0].width, frames[0].height, 3, OIIO::TypeDesc::UINT8);
  // A frame's duration is kept in hundredths of a second.
  const int rate[2] = {100, std::max(1, int(frame_s * 100 + 0.5))};
  spec.attribute("FramesPerSecond", OIIO::TypeRational, rate);
  spec.attribute("oiio:Movie", 1);

  std::vector<unsigned char> encoded;
  OIIO::Filesystem::IOVecOutput sink(encoded);
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("gif");
  if (!output) throw RenderError("cannot write " + path + ": OpenImageIO has no gif writer");
  bool done = output->set_ioproxy(&sink);
  for (const ByteImage& frame : frames) {
    assert(frame.width == spec.width && frame.height == spec.height && frame.channels == 3);
    const auto mode =
        &frame == &frames.front() ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
    done = done && output->open("picture.gif", spec, mode) &&
           output->write_image(OIIO::TypeDesc::UINT8, frame.values.data());
  }
  if (!done || !output->close()) throw_not_encoded(*output, path);
  return encoded;
}

void write_image(const std::string& path, const ByteImage& image) {
  const std::vector<unsigned char> bytes = encode_image(image, image_format_of(path), path);
  write_file_atomically(
      path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace emberline
