#include "io/image/input.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include "io/exr/decoder.h"
#include "io/files/input_file.h"
#include "io/image/codecs.h"
#include "io/image/colour.h"
#include "io/image/encoded_image.h"
#include "io/image/ktx2/ktx2.h"
#include "io/image/library.h"
#include "io/image/texel_repair.h"
#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Limit on the width and height that an image states. The value is our choice. The largest
// panoramas in use are 32k wide.
constexpr int64_t kMaxSide = 65536;
// Limit on the data window's position. It keeps sums far from overflow.
constexpr int64_t kMaxWindowOffset = int64_t(1) << 24;

constexpr const char* kDecodeError = "cannot decode the image: ";

constexpr std::array kTextureFormats = {ImageFormat::kPng, ImageFormat::kJpeg, ImageFormat::kWebp,
                                        ImageFormat::kExr, ImageFormat::kHdr,  ImageFormat::kKtx2};
constexpr std::array kEnvironmentFormats = {ImageFormat::kExr, ImageFormat::kHdr};
constexpr std::array kRowFormats = {ImageFormat::kExr};
constexpr std::array kPictureFormats = {ImageFormat::kExr,  ImageFormat::kHdr,  ImageFormat::kPng,
                                        ImageFormat::kJpeg, ImageFormat::kWebp, ImageFormat::kTiff};

using Bytes = std::span<const uint8_t>;
using Formats = std::span<const ImageFormat>;

std::unique_ptr<ImageDecoder> open_with_library(ImageFormat format, const ByteSource& source,
                                                std::string& error) {
  return image_library().open(format == ImageFormat::kWebp ? "webp" : "tiff", source, error);
}

ImageFormat detect_format(Bytes bytes, Formats allowed, const std::string& place) {
  const ImageFormat format = sniff_image_format(bytes);
  if (std::ranges::find(allowed, format) != allowed.end()) return format;
  std::string names;
  for (size_t i = 0; i < allowed.size(); ++i) {
    names += i == 0 ? "" : i + 1 < allowed.size() ? ", " : " or ";
    names += format_name(allowed[i]);
  }
  throw InputError(place, (format == ImageFormat::kNone
                               ? "the image is not "
                               : "the image is " + std::string(format_name(format)) + ", not ") +
                              names);
}

constexpr std::array kSampleTypes = {SampleType::kUint8, SampleType::kUint16, SampleType::kHalf,
                                     SampleType::kFloat};  // by TexelType

TexelType texel_type(SampleType type) {
  const auto* found = std::ranges::find(kSampleTypes, type);
  return found == kSampleTypes.end() ? TexelType::kFloat : TexelType(found - kSampleTypes.begin());
}

// Returns the type of these channels, or kFloat if their types differ.
SampleType common_type(const ImageLayout& layout, int first, int end) {
  const auto types = std::span(layout.channel_types).subspan(size_t(first), size_t(end - first));
  const bool is_one = std::ranges::all_of(types, [&](SampleType t) { return t == types[0]; });
  return is_one ? types[0] : SampleType::kFloat;
}

bool is_float(SampleType type) { return type == SampleType::kHalf || type == SampleType::kFloat; }

size_t bytes_of(SampleType type) {
  if (type == SampleType::kUint8) return 1;
  return type == SampleType::kUint16 || type == SampleType::kHalf ? 2 : 4;
}

void check_size(int64_t width, int64_t height, const std::string& place) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1) throw InputError(place, "the image is empty ({})", size);
  if (width > kMaxSide || height > kMaxSide) {
    throw InputError(place, "the image is too large ({}; at most {} pixels a side)", size,
                     kMaxSide);
  }
}

ByteSource make_byte_source(Bytes memory) {
  return {memory.size(), [memory](uint64_t offset, size_t count, void* bytes) {
            if (offset >= memory.size()) return size_t(0);
            const size_t got = std::min(count, memory.size() - size_t(offset));
            std::memcpy(bytes, memory.data() + offset, got);
            return got;
          }};
}

// An opened image whose pixels are not decoded yet.
class OpenImage {
 public:
  // `bytes` must outlive this object.
  OpenImage(Bytes bytes, Formats allowed, const std::string& place, const LoadProgress& progress)
      : place_(place), progress_(progress) {
    open_bytes(bytes, allowed);
  }
  // EXR and HDR are read from the file during decoding, so that a large frame is not in memory
  // twice. PNG, JPEG, WebP and TIFF files are read as a whole.
  OpenImage(const std::string& path, Formats allowed, const LoadProgress& progress)
      : place_(path), progress_(progress) {
    InputFile file(path);
    std::array<uint8_t, 12> magic = {};
    const int64_t got = file.try_read(0, magic.size(), magic.data());
    if (got <= 0) throw InputError(place_, "the image is empty");
    const ImageFormat format = detect_format(Bytes(magic).first(size_t(got)), allowed, place_);
    if (format == ImageFormat::kExr || format == ImageFormat::kHdr) {
      open_in_place(format, make_byte_source(std::move(file)));
    } else {
      const MemoryReservation encoded(progress.budget(), MemoryPart::kFile, file.size(), place_);
      open_bytes(file.read_all(progress), allowed);
    }
  }

  const ImageLayout& layout() const { return layout_; }
  std::string attribute(const char* name) const { return decoder_->attribute(name); }
  bool truncated() const { return truncated_; }
  const std::string& place() const { return place_; }

  // Returns the pixels' position in the frame.
  Rect data_window() const {
    const ImageLayout& s = layout_;
    const int64_t x = int64_t(s.x) - s.full_x, y = int64_t(s.y) - s.full_y;
    check_size(s.full_width, s.full_height, place_);
    if (std::max(std::abs(x), std::abs(y)) > kMaxWindowOffset) {
      throw InputError(place_, "its data window lies far outside its display window");
    }
    return {int(x), int(y), int(x) + s.width, int(y) + s.height};
  }

  // Reads rows [begin, end) of all channels. The range must consist of whole tiles.
  void read_rows(int begin, int end, float* values) {
    const ImageLayout& s = layout_;
    const size_t row = size_t(s.width) * size_t(s.channels()) * sizeof(float);
    progress_.check();
    const std::string error =
        decoder_->read({0, begin, s.width, end}, 0, s.channels(), SampleType::kFloat,
                       reinterpret_cast<std::byte*>(values), row);
    if (!error.empty()) throw InputError(place_, kDecodeError + error);
  }

  // Reads `channels` channels of the data window, starting with channel `first`. The values are
  // interleaved, with rows from the top. `values` grows as rows are read, because clearing
  // gigabytes at once would take seconds in which the load could not be cancelled.
  template <typename Value>
  void read(int first, int channels, SampleType type, std::vector<Value>& values) {
    constexpr size_t kPartBytes = size_t(4) << 20;  // cancellation is checked between parts
    const ImageLayout& s = layout_;
    const size_t pixel = size_t(channels) * bytes_of(type), row = size_t(s.width) * pixel;
    progress_.budget()->reserve(MemoryPart::kTextures, size_t(s.height) * row, place_);
    values.reserve(size_t(s.height) * row / sizeof(Value));
    const auto parts = [&](size_t bytes) { return std::max(size_t(1), kPartBytes / bytes); };
    const auto block = size_t(s.rows_per_block);
    size_t across = size_t(s.width), down = std::max<size_t>(1, parts(row) / block) * block;
    if (s.tile_width > 0) {
      down = size_t(s.tile_height);
      across = parts(size_t(s.tile_width) * down * pixel) * size_t(s.tile_width);
    }
    for (size_t y = 0; y < size_t(s.height); y += down) {
      resize_in_steps(values, std::min(y + down, size_t(s.height)) * row / sizeof(Value));
      auto* const texels = reinterpret_cast<std::byte*>(values.data());
      for (size_t x = 0; x < size_t(s.width); x += across) {
        progress_.check();
        const Rect part = {int(x), int(y), int(std::min(x + across, size_t(s.width))),
                           int(std::min(y + down, size_t(s.height)))};
        const std::string error =
            decoder_->read(part, first, first + channels, type, texels + y * row + x * pixel, row);
        if (!error.empty()) throw InputError(place_, kDecodeError + error);
      }
    }
    decoder_.reset();
    apply_orientation(reinterpret_cast<std::byte*>(values.data()), pixel);
  }

 private:
  // Resizes in steps, since the system clears the reserved memory page by page. This takes time, so
  // cancellation is checked between the steps.
  template <typename Value>
  void resize_in_steps(std::vector<Value>& values, size_t size) const {
    constexpr size_t kStep = (size_t(64) << 20) / sizeof(Value);
    while (values.size() < size) {
      progress_.check();
      values.resize(std::min(size, values.size() + kStep));
    }
  }

  void open_bytes(Bytes bytes, Formats allowed) {
    if (bytes.empty()) throw InputError(place_, "the image is empty");
    const ImageFormat format = detect_format(bytes, allowed, place_);
    if (format == ImageFormat::kExr || format == ImageFormat::kHdr) {
      return open_in_place(format, make_byte_source(bytes));
    }
    input_memory_.add(bytes.size(), place_);
    if (format == ImageFormat::kTiff) {
      bytes_.assign(bytes.begin(), bytes.end());
      clean_tiff(bytes_, place_);
    } else if (format == ImageFormat::kKtx2) {
      bytes_.assign(bytes.begin(), bytes.end());
      header_ = read_ktx2_header(bytes_, place_);
    } else {
      CleanImage clean = clean_image(format, bytes, place_);
      bytes_ = std::move(clean.bytes);
      header_ = clean.header;
      truncated_ = clean.truncated;
    }
    source_ = make_byte_source(Bytes(bytes_));
    open(format);
  }

  void open_in_place(ImageFormat format, ByteSource source) {
    source_ = std::move(source);
    header_ = format == ImageFormat::kExr ? read_exr_header(source_, place_)
                                          : read_hdr_header(source_, place_);
    if (header_.orientation > 4) {
      throw InputError(place_, "the image is stored by columns; save it by rows");
    }
    open(format);
  }

  void open(ImageFormat format) {
    // Only the decoder knows a TIFF's size.
    if (format != ImageFormat::kTiff) check_size(header_.width, header_.height, place_);
    decoder_memory_.add(uint64_t(header_.width) * uint64_t(header_.height) *
                                uint64_t(header_.decoder_bytes_per_pixel) +
                            header_.tile_bytes,
                        place_);
    std::string error;
    decoder_ = format == ImageFormat::kPng    ? open_png(bytes_, error)
               : format == ImageFormat::kJpeg ? open_jpeg(bytes_, error)
               : format == ImageFormat::kKtx2 ? open_ktx2(bytes_, place_)
               : format == ImageFormat::kHdr  ? open_hdr(source_, header_)
               : format == ImageFormat::kExr  ? open_exr(source_, header_, reserve_threads(), error)
                                              : open_with_library(format, source_, error);
    if (!decoder_) throw InputError(place_, kDecodeError + error);
    layout_ = decoder_->layout();
    if (layout_.chromaticities) layout_.view.space = working_space_of(*layout_.chromaticities);
    const ImageLayout& s = layout_;
    check_size(s.width, s.height, place_);
    // The decoder may parse an ambiguous header differently. Its size must be the one that was
    // checked.
    if (format != ImageFormat::kTiff && (s.width != header_.width || s.height != header_.height)) {
      throw InputError(place_, std::string(kDecodeError) + "its header is ambiguous");
    }
    if (s.depth > 1 || s.channels() < 1 || s.channels() > kMaxChannels || s.deep) {
      throw InputError(place_, "the image is not a flat picture with 1 to {} channels",
                       kMaxChannels);
    }
    if (format == ImageFormat::kTiff) {
      header_.orientation = s.orientation;
      // The decoder keeps a strip or tile, which may be as large as the image.
      const uint64_t tile =
          uint64_t(s.tile_width) * uint64_t(s.tile_height) * uint64_t(s.channels()) * sizeof(float);
      decoder_memory_.add(std::max(s.bytes, tile), place_);
    }
  }

  // Returns the number of threads that decode an EXR, and reserves their memory beyond the first
  // thread's. Images with large tiles, or loads with little memory left, have fewer threads.
  int reserve_threads() {
    constexpr uint64_t kMaxBytes = uint64_t(32) << 20;
    auto threads = std::clamp<uint64_t>(kMaxBytes / header_.tile_bytes, 1, worker_count());
    for (; threads > 1; threads /= 2) {
      try {
        decoder_memory_.add((threads - 1) * header_.tile_bytes, place_);
        break;
      } catch (const LimitError&) {
      }
    }
    return int(threads);
  }

  // Flips and mirrors the stored rows as header_.orientation says.
  void apply_orientation(std::byte* texels, size_t pixel) const {
    const ImageLayout& s = layout_;
    const size_t width = size_t(s.width), height = size_t(s.height), row = width * pixel;
    const int turn = header_.orientation;
    if (turn == 3 || turn == 4) {
      for (size_t y = 0; y < height / 2; ++y) {
        std::swap_ranges(texels + y * row, texels + (y + 1) * row, texels + (height - 1 - y) * row);
      }
    }
    if (turn != 2 && turn != 3) return;
    for (size_t y = 0; y < height; ++y) {
      std::byte* const line = texels + y * row;
      for (size_t x = 0; x < width / 2; ++x) {
        std::swap_ranges(line + x * pixel, line + (x + 1) * pixel, line + (width - 1 - x) * pixel);
      }
    }
  }

  const std::string place_;
  const LoadProgress& progress_;
  MemoryReservation input_memory_{progress_.budget(), MemoryPart::kFile};
  MemoryReservation decoder_memory_{progress_.budget(), MemoryPart::kTextures};
  ImageHeader header_;
  bool truncated_ = false;
  std::vector<uint8_t> bytes_;  // the decoder's input, unless the decoder reads the original bytes
  ByteSource source_;
  std::unique_ptr<ImageDecoder> decoder_;  // after its input, so that it is destroyed first
  ImageLayout layout_;
};

// Decodes channels of an image whose pixels must cover its frame. Crops pixels outside the frame.
void read_frame(OpenImage& input, int first, Image& image) {
  const ImageLayout& layout = input.layout();
  const SampleType type = kSampleTypes[size_t(image.type)];
  const Rect data = input.data_window(), frame{0, 0, layout.full_width, layout.full_height};
  if (data.intersect(frame) != frame) {
    throw InputError(
        input.place(),
        "its data window does not cover its display window: {} x {} from ({}, {}) in {} x {}",
        data.width(), data.height(), data.x0, data.y0, frame.width(), frame.height());
  }
  const size_t pixel = size_t(image.channels) * bytes_of(type);
  input.read(first, image.channels, type, image.texels);
  image.width = frame.width();
  image.height = frame.height();
  if (data == frame) return;
  const size_t row = size_t(frame.width()) * pixel;
  for (int y = 0; y < frame.height(); ++y) {
    const std::byte* source = image.texels.data() + data.index_of(0, y) * pixel;
    std::copy(source, source + row, image.texels.data() + size_t(y) * row);
  }
  image.texels.resize(size_t(frame.area()) * pixel);
}

}  // namespace

DecodedImage decode_image(std::span<const uint8_t> encoded, const std::string& place, bool lenient,
                          const LoadProgress& progress) try {
  OpenImage input(encoded, kTextureFormats, place, progress);
  if (input.truncated() && !lenient) {
    throw InputError(place, "the JPEG is truncated; use `lenient` to accept it");
  }
  const ImageLayout layout = input.layout();
  std::string transfer = input.attribute(kTransferAttribute);
  auto image = std::make_shared<Image>();
  image->name = place;
  // Formats other than EXR define their channels by position only.
  const ColourChannels colour = layout.parts.empty()
                                    ? ColourChannels{0, std::min(layout.channels(), 4)}
                                    : find_colour(layout.channel_names, layout.parts, place);
  image->channels = colour.end() - colour.first;
  image->type = texel_type(common_type(layout, colour.first, colour.end()));
  read_frame(input, colour.first, *image);
  // The WebP reader (OpenImageIO 2.4) premultiplies although we ask for unassociated alpha. EXR
  // files are premultiplied by convention.
  const bool has_alpha =
      colour.has_alpha || (layout.alpha_channel == image->channels - 1 && image->channels % 2 == 0);
  if (has_alpha && layout.premultiplied) unpremultiply(*image);
  const uint64_t repaired = repair_texels(*image, TexelRange::kFinite);
  return {std::move(image), repaired, input.truncated(), std::move(transfer)};
} catch (const std::bad_alloc&) {
  throw InputError(place, "not enough memory to decode the image");
}

std::shared_ptr<const Image> read_environment(const std::string& path, uint64_t* repaired,
                                              const LoadProgress& progress) try {
  OpenImage input(path, kEnvironmentFormats, progress);
  const ImageLayout& layout = input.layout();
  const ColourChannels colour = find_colour(layout.channel_names, layout.parts, path);
  if (is_cube_map(layout.parts, colour.first)) {
    throw InputError(path, "expected a latitude-longitude environment, found a cube map");
  }
  const bool is_half =
      common_type(layout, colour.first, colour.first + colour.count) == SampleType::kHalf;
  const auto types = std::span(layout.channel_types);
  if (!is_float(layout.type) &&
      !std::ranges::all_of(types.subspan(size_t(colour.first), size_t(colour.count)), is_float)) {
    throw InputError(
        path, "an environment needs half or float texels (.exr or .hdr), but this image has " +
                  layout.type_name);
  }
  const bool grey = colour.count == 1;

  auto image = std::make_shared<Image>();
  image->name = path;
  image->type = is_half ? TexelType::kHalf : TexelType::kFloat;
  image->channels = grey ? 1 : 3;
  read_frame(input, colour.first, *image);
  if (grey) expand_grey(*image);
  uint64_t count = 0;
  if (layout.chromaticities && !grey) {
    if (const ToWorkingSpace matrix = to_rec709(*layout.chromaticities, path)) {
      count += repair_texels(*image, TexelRange::kFinite);
      convert_primaries(*image, *matrix);
    }
  }
  count += repair_texels(*image, TexelRange::kRadiance);
  if (repaired) *repaired += count;
  return image;
} catch (const std::bad_alloc&) {
  throw InputError(path, "not enough memory for the image");
}

int FloatImage::find_channel(const std::string& name) const {
  const auto found = std::ranges::find(channel_names, name);
  return found == channel_names.end() ? -1 : int(found - channel_names.begin());
}

namespace {

// Returns the image's description, without values.
FloatImage image_description(OpenImage& input) {
  const ImageLayout& layout = input.layout();
  FloatImage image;
  image.width = layout.width;
  image.height = layout.height;
  image.data_window = input.data_window();
  image.space = layout.view.space;
  image.chromaticities = layout.chromaticities;
  image.frame_width = layout.full_width;
  image.frame_height = layout.full_height;
  image.channel_names = layout.channel_names;
  image.parts = layout.parts;
  if (input.attribute("emberline:complete") == "false") {
    const std::string samples = input.attribute("emberline:samples");
    image.stopped_after = std::strtoull(samples.c_str(), nullptr, 10);
  }
  return image;
}

// Converts integer channels, except alpha, to linear. The integers of an EXR are counters, which
// stay as they are.
void convert_stored(const ImageLayout& layout, std::vector<float>& values) {
  if (!layout.parts.empty()) return;
  const size_t channels = size_t(layout.channels());
  for (size_t c = 0; c < channels; ++c) {
    const SampleType type = layout.channel_types[c];
    if (is_float(type) || int(c) == layout.alpha_channel) continue;
    for (size_t i = c; i < values.size(); i += channels) values[i] = srgb_to_linear(values[i]);
  }
}

}  // namespace

FloatImage read_float_image(const std::string& path, const LoadProgress& progress) try {
  OpenImage input(path, kPictureFormats, progress);
  if (input.truncated()) throw InputError(path, "the JPEG is truncated");
  const ImageLayout layout = input.layout();
  FloatImage image = image_description(input);
  input.read(0, layout.channels(), SampleType::kFloat, image.values);
  convert_stored(layout, image.values);
  return image;
} catch (const std::bad_alloc&) {
  throw InputError(path, "not enough memory for the image");
}

struct FloatImageRows::Impl {
  Impl(const std::string& path, const LoadProgress& progress)
      : input(path, kRowFormats, progress), image(image_description(input)) {}

  OpenImage input;
  FloatImage image;
  int next = 0;  // the next row to read
};

FloatImageRows::FloatImageRows(const std::string& path, const LoadProgress& progress)
    : impl_(std::make_unique<Impl>(path, progress)) {}
FloatImageRows::~FloatImageRows() = default;

const FloatImage& FloatImageRows::image() const { return impl_->image; }

ChannelType FloatImageRows::channel_type(size_t channel) const {
  const SampleType type = impl_->input.layout().channel_types[channel];
  return type == SampleType::kUint32 ? ChannelType::kUint
         : type == SampleType::kHalf ? ChannelType::kHalf
                                     : ChannelType::kFloat;
}

const std::vector<std::pair<std::string, std::string>>& FloatImageRows::text_attributes() const {
  return impl_->input.layout().text_attributes;
}

const ExrView& FloatImageRows::view() const { return impl_->input.layout().view; }

int FloatImageRows::tile_size() const {
  constexpr int kRows = 64;
  const int height = impl_->input.layout().tile_height;
  return height > 0 ? height : kRows;
}

int FloatImageRows::rows_at_once() const { return std::max(1, impl_->input.layout().tile_height); }

void FloatImageRows::read(int rows, std::vector<float>& values) {
  const ImageLayout& layout = impl_->input.layout();
  assert(impl_->next + rows <= layout.height);
  values.resize(size_t(layout.width) * size_t(rows) * size_t(layout.channels()));
  impl_->input.read_rows(impl_->next, impl_->next + rows, values.data());
  impl_->next += rows;
  convert_stored(layout, values);
}

}  // namespace emberline
