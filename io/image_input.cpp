#include "io/image_input.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstring>
#include <new>

#include "io/texel_repair.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

namespace oiio = OIIO;

// Chosen by us: what an image may ask for before a byte of it is decoded. The largest panoramas
// in use are 32k wide.
constexpr int kLargestSide = 65536;
constexpr int64_t kMostBytes = int64_t(1) << 31;

// OpenImageIO's name for the format, from the first bytes; empty for anything else. The suffix or
// media type of an image says less: exporters get it wrong.
std::string sniff_format(std::span<const uint8_t> bytes) {
  const auto starts_with = [&](std::string_view magic, size_t offset = 0) {
    return bytes.size() >= offset + magic.size() &&
           std::memcmp(bytes.data() + offset, magic.data(), magic.size()) == 0;
  };
  if (starts_with("\x89PNG\r\n\x1a\n")) return "png";
  if (starts_with("\xff\xd8\xff")) return "jpeg";
  if (starts_with("RIFF") && starts_with("WEBP", 8)) return "webp";
  if (starts_with("\x76\x2f\x31\x01")) return "openexr";
  if (starts_with("#?")) return "hdr";
  return "";
}

// A PNG that ends early makes libpng jump out of OpenImageIO's reader past its destructors, so the
// chunks (PNG specification section 5.3: length, type, data, CRC) are walked first.
void check_png_is_whole(std::span<const uint8_t> bytes, const std::string& place) {
  size_t offset = 8;
  while (bytes.size() - offset >= 12) {
    const uint64_t length = uint64_t(bytes[offset]) << 24 | uint64_t(bytes[offset + 1]) << 16 |
                            uint64_t(bytes[offset + 2]) << 8 | bytes[offset + 3];
    if (length > bytes.size() - offset - 12) break;
    if (std::memcmp(&bytes[offset + 4], "IEND", 4) == 0) return;
    offset += size_t(length) + 12;
  }
  throw InputError(place, "the image does not decode: the PNG is truncated");
}

// OpenImageIO's message as one line.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (uint8_t(c) < 0x20) c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.empty() ? "unknown reason" : text.substr(0, 200);
}

TexelType texel_type(oiio::TypeDesc format) {
  switch (format.basetype) {
    case oiio::TypeDesc::UINT8:
      return TexelType::kUint8;
    case oiio::TypeDesc::UINT16:
      return TexelType::kUint16;
    case oiio::TypeDesc::HALF:
      return TexelType::kHalf;
    default:
      return TexelType::kFloat;
  }
}

oiio::TypeDesc oiio_type(TexelType type) {
  switch (type) {
    case TexelType::kUint8:
      return oiio::TypeDesc::UINT8;
    case TexelType::kUint16:
      return oiio::TypeDesc::UINT16;
    case TexelType::kHalf:
      return oiio::TypeDesc::HALF;
    case TexelType::kFloat:
      return oiio::TypeDesc::FLOAT;
  }
  return oiio::TypeDesc::FLOAT;
}

void check_size(const oiio::ImageSpec& spec, int channels, oiio::TypeDesc type, int64_t most_bytes,
                const std::string& place) {
  const std::string size = std::to_string(spec.width) + " x " + std::to_string(spec.height);
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1) {
    throw InputError(place, "the image is empty or not two-dimensional (" + size + ")");
  }
  const int64_t bytes = int64_t(spec.width) * spec.height * channels * int64_t(type.size());
  if (spec.width > kLargestSide || spec.height > kLargestSide || bytes > most_bytes) {
    throw InputError(place, "the image is too large (" + size + "; at most " +
                                std::to_string(kLargestSide) + " pixels a side and " +
                                std::to_string(most_bytes >> 20) + " MiB)");
  }
}

// `image.channels` channels from `first_channel` of an open image, some megabytes of rows at a
// time: between them it can be called off.
void read_texels(oiio::ImageInput& input, int first_channel, Image& image, const std::string& place,
                 const LoadProgress& progress) {
  constexpr size_t kPart = size_t(4) << 20;
  const oiio::TypeDesc type = oiio_type(image.type);
  image.texels.resize(size_t(image.width) * size_t(image.height) * size_t(image.channels) *
                      type.size());
  const int last_channel = first_channel + image.channels;
  const size_t row_bytes = size_t(image.width) * size_t(image.channels) * type.size();
  const bool tiled = input.spec().tile_width > 0;
  const int part = tiled ? image.height : int(std::max(size_t(1), kPart / row_bytes));
  for (int row = 0; row < image.height; row += part) {
    progress.check();
    const int y = input.spec().y + row, end = std::min(y + part, input.spec().y + image.height);
    std::byte* texels = image.texels.data() + size_t(row) * row_bytes;
    if (!(tiled ? input.read_image(0, 0, first_channel, last_channel, type, texels)
                : input.read_scanlines(0, 0, y, end, input.spec().z, first_channel, last_channel,
                                       type, texels))) {
      throw InputError(place, "the image does not decode: " + one_line(input.geterror()));
    }
  }
}

std::unique_ptr<oiio::ImageInput> open_file(const std::string& path) {
  oiio::ImageSpec hints;
  hints["oiio:UnassociatedAlpha"] = 1;
  auto input = oiio::ImageInput::open(path, &hints);
  if (!input) throw InputError(path, "cannot read the image: " + one_line(oiio::geterror()));
  return input;
}

}  // namespace

std::shared_ptr<const Image> decode_image(std::span<const uint8_t> encoded,
                                          const std::string& place, uint64_t* non_finite,
                                          const LoadProgress& progress) try {
  if (encoded.empty()) throw InputError(place, "the image is empty");
  const std::string format = sniff_format(encoded);
  if (format.empty()) {
    throw InputError(place, "the image is not PNG, JPEG, WebP, EXR or HDR");
  }
  if (format == "png") check_png_is_whole(encoded, place);
  auto input = oiio::ImageInput::create(format);
  if (!input) {
    oiio::geterror();  // or it would greet the next caller
    throw InputError(place, "this OpenImageIO cannot read " + format + " images");
  }
  oiio::ImageSpec hints;
  hints["oiio:UnassociatedAlpha"] = 1;
  oiio::ImageSpec spec;
  oiio::Filesystem::IOMemReader reader(const_cast<uint8_t*>(encoded.data()), encoded.size());
  if (!input->supports("ioproxy") || !input->set_ioproxy(&reader)) {
    throw InputError(place, "this OpenImageIO cannot read " + format + " images from memory");
  }
  if (!input->open("image." + format, spec, hints)) {
    throw InputError(place, "the image does not decode: " + one_line(input->geterror()));
  }

  auto image = std::make_shared<Image>();
  image->name = place;
  image->type = texel_type(spec.format);
  image->channels = std::min(spec.nchannels, 4);
  check_size(spec, image->channels, oiio_type(image->type), kMostBytes, place);
  image->width = spec.width;
  image->height = spec.height;
  read_texels(*input, 0, *image, place, progress);
  input->close();
  // The WebP reader (OpenImageIO 2.4) multiplies whatever the hint says; EXR is so by convention.
  const bool has_alpha = spec.alpha_channel == image->channels - 1 && image->channels % 2 == 0;
  if (has_alpha && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0) unpremultiply(*image);
  const uint64_t repaired = repair_texels(*image, TexelRange::kFinite);
  if (non_finite) *non_finite += repaired;
  return image;
} catch (const std::bad_alloc&) {
  throw InputError(place, "no memory to decode the image");
}

std::shared_ptr<const Image> read_environment(const std::string& path, uint64_t* repaired,
                                              const LoadProgress& progress) try {
  auto input = open_file(path);
  const oiio::ImageSpec& spec = input->spec();
  const bool is_half = spec.format == oiio::TypeDesc::HALF;
  if (!is_half && spec.format != oiio::TypeDesc::FLOAT) {
    throw InputError(path, "an environment needs half or float texels (.exr or .hdr), this has " +
                               std::string(spec.format.c_str()));
  }
  // Colour first, wherever it stands; alpha and the rest are left out.
  int first = 0;
  const int red = spec.channelindex("R");
  if (spec.nchannels >= 3) {
    if (red >= 0 && (spec.channelindex("G") != red + 1 || spec.channelindex("B") != red + 2)) {
      throw InputError(path, "the channels R, G and B do not stand together");
    }
    if (red < 0 && (spec.channelindex("RY") >= 0 || spec.channelindex("BY") >= 0)) {
      throw InputError(path, "luminance-chroma EXR is not supported, save it as RGB");
    }
    first = std::max(red, 0);
  } else if (spec.nchannels == 2 && spec.alpha_channel != 1) {
    throw InputError(path, "an environment needs 1, 3 or 4 channels, this has 2");
  }
  const bool grey = spec.nchannels < 3;

  auto image = std::make_shared<Image>();
  image->name = path;
  image->type = is_half ? TexelType::kHalf : TexelType::kFloat;
  image->channels = grey ? 1 : 3;
  // A 32k float map is 6 GiB: allowed, the user named this file.
  check_size(spec, 3, oiio_type(image->type), int64_t(1) << 34, path);
  image->width = spec.width;
  image->height = spec.height;
  read_texels(*input, first, *image, path, progress);
  input->close();
  if (grey) expand_grey(*image);
  const uint64_t count = repair_texels(*image, TexelRange::kRadiance);
  if (repaired) *repaired += count;
  return image;
} catch (const std::bad_alloc&) {
  throw InputError(path, "no memory for the image");
}

int FloatImage::find_channel(const std::string& name) const {
  for (size_t i = 0; i < channel_names.size(); ++i) {
    if (channel_names[i] == name) return int(i);
  }
  return -1;
}

FloatImage read_float_image(const std::string& path) try {
  auto input = open_file(path);
  const oiio::ImageSpec spec = input->spec();
  check_size(spec, spec.nchannels, oiio::TypeDesc::FLOAT, int64_t(1) << 36, path);
  FloatImage image;
  image.width = spec.width;
  image.height = spec.height;
  const int x = spec.x - spec.full_x, y = spec.y - spec.full_y;
  image.data_window = {x, y, x + spec.width, y + spec.height};
  image.frame_width = spec.full_width;
  image.frame_height = spec.full_height;
  image.channel_names.assign(spec.channelnames.begin(), spec.channelnames.end());
  const size_t channels = size_t(spec.nchannels);
  image.values.resize(size_t(spec.width) * size_t(spec.height) * channels);
  if (!input->read_image(0, 0, 0, spec.nchannels, oiio::TypeDesc::FLOAT, image.values.data())) {
    throw InputError(path, "the image does not decode: " + one_line(input->geterror()));
  }
  for (size_t c = 0; c < channels; ++c) {
    const oiio::TypeDesc type = spec.channelformat(int(c));
    const bool is_float = type.is_floating_point();
    // A counter channel of an EXR (UINT) comes scaled to [0, 1]; undone exactly up to 2^24.
    const bool is_counter = type == oiio::TypeDesc::UINT32;
    if (is_float || (int(c) == spec.alpha_channel && !is_counter)) continue;
    for (size_t i = c; i < image.values.size(); i += channels) {
      image.values[i] = is_counter ? float(std::round(double(image.values[i]) * 0x1p32))
                                   : srgb_to_linear(image.values[i]);
    }
  }
  return image;
} catch (const std::bad_alloc&) {
  throw InputError(path, "no memory for the image");
}

}  // namespace emberline
