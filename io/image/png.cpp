#include <png.h>

#include <bit>
#include <cassert>
#include <cstdio>
#include <cstring>
#include <new>

#include "io/image/codecs.h"
#include "io/image/file_completeness.h"

namespace emberline {
namespace {

using Bytes = std::span<const uint8_t>;

// libpng reports errors by longjmp, so no object with a destructor may be created between setjmp
// and a call that can fail. Warnings are ignored.
struct PngFailure {
  char message[200] = "";
};

[[noreturn]] void on_png_error(png_structp png, png_const_charp message) {
  auto& failure = *static_cast<PngFailure*>(png_get_error_ptr(png));
  std::snprintf(failure.message, sizeof failure.message, "%s", message);
  png_longjmp(png, 1);
}

void on_png_warning(png_structp, png_const_charp) {}

class PngDecoder final : public ImageDecoder {
 public:
  PngDecoder() = default;
  PngDecoder(const PngDecoder&) = delete;
  PngDecoder& operator=(const PngDecoder&) = delete;
  ~PngDecoder() override { png_destroy_read_struct(&png_, &info_, nullptr); }

  std::string open(Bytes bytes) {
    unread_ = bytes;
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure_, on_png_error, on_png_warning);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_) throw std::bad_alloc();
    if (!read_header()) return failure_.message;
    constexpr const char* kNames[] = {"Y", "A", "R", "G", "B", "A"};
    const int channels = png_get_channels(png_, info_), first = channels < 3 ? 0 : 2;
    set_layout(int(png_get_image_width(png_, info_)), int(png_get_image_height(png_, info_)),
               {kNames + first, kNames + first + channels},
               png_get_bit_depth(png_, info_) == 16 ? SampleType::kUint16 : SampleType::kUint8);
    layout_.alpha_channel = channels % 2 == 0 ? channels - 1 : -1;
    return "";
  }

  std::string read(const Rect& pixels, [[maybe_unused]] int first, int last, SampleType type,
                   std::byte* out, size_t row) override {
    assert(first == 0 && last == layout_.channels());
    const size_t stored = png_get_rowbytes(png_, info_);
    if (is_interlaced() && interlaced_image_.empty()) {
      interlaced_image_.resize(stored * size_t(layout_.height));
      rows_.resize(size_t(layout_.height));
      for (size_t y = 0; y < rows_.size(); ++y) rows_[y] = interlaced_image_.data() + y * stored;
      if (!read_interlaced()) return failure_.message;
    }
    const bool converts = type != layout_.type;
    if (converts && !is_interlaced()) line_.resize(stored);
    const size_t samples = size_t(layout_.width) * size_t(last);
    for (int y = pixels.y0; y < pixels.y1; ++y, out += row) {
      if (is_interlaced()) {
        convert(rows_[size_t(y)], samples, type, out);
      } else if (!read_row(converts ? line_.data() : reinterpret_cast<png_bytep>(out))) {
        return failure_.message;
      } else if (converts) {
        convert(line_.data(), samples, type, out);
      }
    }
    return "";
  }

 private:
  static void take(png_structp png, png_bytep out, size_t count) {
    Bytes& unread = static_cast<PngDecoder*>(png_get_io_ptr(png))->unread_;
    if (count > unread.size()) png_error(png, "it is truncated");
    std::memcpy(out, unread.data(), count);
    unread = unread.subspan(count);
  }

  bool is_interlaced() const { return passes_ > 1; }

  bool read_header() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_read_fn(png_, this, take);
    png_read_info(png_, info_);
    png_set_expand(png_);
    if (std::endian::native == std::endian::little) png_set_swap(png_);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  bool read_interlaced() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_image(png_, rows_.data());
    return true;
  }
  bool read_row(png_bytep out) {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_row(png_, out, nullptr);
    return true;
  }

  void convert(const uint8_t* samples, size_t count, SampleType type, std::byte* out) const {
    const size_t size = layout_.type == SampleType::kUint16 ? 2 : 1;
    if (type == layout_.type) {
      std::memcpy(out, samples, count * size);
      return;
    }
    assert(type == SampleType::kFloat);
    for (size_t i = 0; i < count; ++i) {
      uint16_t sample = 0;
      if (size == 2) std::memcpy(&sample, samples + 2 * i, 2);
      const float value = size == 2 ? float(sample) / 65535.0f : float(samples[i]) / 255.0f;
      std::memcpy(out + sizeof value * i, &value, sizeof value);
    }
  }

  Bytes unread_;
  PngFailure failure_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;
  std::vector<uint8_t> line_, interlaced_image_;  // a row to convert, and a whole interlaced image
  std::vector<png_bytep> rows_;
};

void append_png(png_structp png, png_bytep bytes, size_t count) {
  auto& out = *static_cast<std::vector<unsigned char>*>(png_get_io_ptr(png));
  bool fits = true;
  try {
    out.insert(out.end(), bytes, bytes + count);
  } catch (const std::bad_alloc&) {
    fits = false;
  }
  if (!fits) png_error(png, "out of memory");
}

bool write_png(png_structp png, png_infop info, const ByteImage& picture,
               std::vector<unsigned char>& encoded) {
  if (setjmp(png_jmpbuf(png))) return false;
  const int colour = picture.channels == 1   ? PNG_COLOR_TYPE_GRAY
                     : picture.channels == 3 ? PNG_COLOR_TYPE_RGB
                                             : PNG_COLOR_TYPE_RGB_ALPHA;
  png_set_write_fn(png, &encoded, append_png, nullptr);
  png_set_IHDR(png, info, png_uint_32(picture.width), png_uint_32(picture.height), 8, colour,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (picture.srgb) png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_text text = {};
  text.compression = PNG_TEXT_COMPRESSION_NONE;
  text.key = const_cast<png_charp>(kCompleteAttribute);  // libpng copies the key
  text.text = const_cast<png_charp>("false");
  if (picture.incomplete) png_set_text(png, info, &text, 1);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_write_info(png, info);
  const size_t row = size_t(picture.width) * size_t(picture.channels);
  for (size_t y = 0; y < size_t(picture.height); ++y) {
    png_write_row(png, picture.values.data() + y * row);
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

std::unique_ptr<ImageDecoder> open_png(Bytes bytes, std::string& error) {
  return open_decoder<PngDecoder>(error, bytes);
}

std::string encode_png(const ByteImage& picture, std::vector<unsigned char>& encoded) {
  PngFailure failure;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, on_png_error, on_png_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool done = info && write_png(png, info, picture, encoded);
  png_destroy_write_struct(&png, &info);
  return done ? "" : info ? failure.message : "out of memory";
}

}  // namespace emberline
