#include <cassert>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <jpeglib.h>

#include "io/image/codecs.h"
#include "io/image/file_completeness.h"

namespace emberline {
namespace {

using Bytes = std::span<const uint8_t>;

// libjpeg reports errors by longjmp, so no object with a destructor may be created between setjmp
// and a call that can fail. Warnings about damaged data are ignored, since clean_image()
// (io/image/encoded_image.h) has already detected a missing end.
struct JpegFailure {
  jpeg_error_mgr manager = {};
  std::jmp_buf jump = {};
  char message[JMSG_LENGTH_MAX] = "";

  JpegFailure() {
    jpeg_std_error(&manager);
    manager.error_exit = fail;
    manager.output_message = [](j_common_ptr) {};
  }
  [[noreturn]] static void fail(j_common_ptr info) {
    auto& failure = *reinterpret_cast<JpegFailure*>(info->err);  // the manager is the first member
    info->err->format_message(info, failure.message);
    std::longjmp(failure.jump, 1);
  }
};

class JpegDecoder final : public ImageDecoder {
 public:
  JpegDecoder() { info_.err = &failure_.manager; }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;
  ~JpegDecoder() override { jpeg_destroy_decompress(&info_); }

  std::string open(Bytes bytes) {
    if (!read_header(bytes)) return failure_.message;
    const int stored = info_.output_components;
    if (stored != 1 && stored != 3 && !is_cmyk()) {
      return "it has " + std::to_string(stored) + " components";
    }
    const std::vector<std::string> names = {"R", "G", "B"};
    set_layout(int(info_.output_width), int(info_.output_height),
               stored == 1 ? std::vector<std::string>{"Y"} : names, SampleType::kUint8);
    line_.resize(size_t(layout_.width) * size_t(stored));
    return "";
  }

  std::string read(const Rect& pixels, [[maybe_unused]] int first, int last, SampleType type,
                   std::byte* out, size_t row) override {
    assert(first == 0 && last == layout_.channels());
    const size_t width = size_t(layout_.width), samples = width * size_t(last);
    for (int y = pixels.y0; y < pixels.y1; ++y, out += row) {
      if (!read_row()) return failure_.message;
      if (is_cmyk()) cmyk_to_rgb(line_.data(), width);
      if (type == SampleType::kUint8) {
        std::memcpy(out, line_.data(), samples);
        continue;
      }
      assert(type == SampleType::kFloat);
      for (size_t i = 0; i < samples; ++i) {
        const float value = float(line_[i]) / 255.0f;
        std::memcpy(out + i * sizeof value, &value, sizeof value);
      }
    }
    return "";
  }

 private:
  bool is_cmyk() const { return info_.out_color_space == JCS_CMYK; }

  bool read_header(Bytes bytes) {
    if (setjmp(failure_.jump)) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, bytes.data(), static_cast<unsigned long>(bytes.size()));
    jpeg_read_header(&info_, TRUE);
    jpeg_start_decompress(&info_);
    return true;
  }
  bool read_row() {
    if (setjmp(failure_.jump)) return false;
    JSAMPROW row = line_.data();
    jpeg_read_scanlines(&info_, &row, 1);
    return true;
  }

  // Converts a row in place. Inks are stored inverted (255 minus ink), as Adobe's programs write
  // them.
  static void cmyk_to_rgb(uint8_t* line, size_t pixels) {
    for (size_t i = 0; i < pixels; ++i) {
      const int black = line[4 * i + 3];
      for (size_t c = 0; c < 3; ++c)
        line[3 * i + c] = uint8_t((line[4 * i + c] * black + 127) / 255);
    }
  }

  JpegFailure failure_;
  jpeg_decompress_struct info_ = {};
  std::vector<uint8_t> line_;
};

struct JpegEncoder {
  JpegFailure failure;
  jpeg_compress_struct info = {};
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  std::vector<uint8_t> line;

  JpegEncoder() { info.err = &failure.manager; }
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  ~JpegEncoder() {
    jpeg_destroy_compress(&info);
    std::free(bytes);
  }

  bool write(const ByteImage& picture) {
    const size_t channels = size_t(picture.channels), written_channels = channels == 1 ? 1 : 3;
    const size_t pixels = size_t(picture.width);
    line.resize(pixels * written_channels);
    if (setjmp(failure.jump)) return false;
    jpeg_create_compress(&info);
    jpeg_mem_dest(&info, &bytes, &count);
    info.image_width = JDIMENSION(picture.width);
    info.image_height = JDIMENSION(picture.height);
    info.input_components = int(written_channels);
    info.in_color_space = written_channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, 95, TRUE);
    for (size_t c = 0; c < written_channels; ++c) {
      info.comp_info[c].h_samp_factor = info.comp_info[c].v_samp_factor = 1;
    }
    jpeg_start_compress(&info, TRUE);
    if (picture.incomplete) {
      jpeg_write_marker(&info, JPEG_COM, reinterpret_cast<const JOCTET*>(kIncompleteComment.data()),
                        unsigned(kIncompleteComment.size()));
    }
    for (size_t y = 0; y < size_t(picture.height); ++y) {
      const uint8_t* const source = picture.values.data() + y * pixels * channels;
      for (size_t x = 0; x < pixels; ++x) {
        for (size_t c = 0; c < written_channels; ++c)
          line[x * written_channels + c] = source[x * channels + c];
      }
      JSAMPROW row = line.data();
      jpeg_write_scanlines(&info, &row, 1);
    }
    jpeg_finish_compress(&info);
    return true;
  }
};

}  // namespace

std::unique_ptr<ImageDecoder> open_jpeg(Bytes bytes, std::string& error) {
  return open_decoder<JpegDecoder>(error, bytes);
}

std::string encode_jpeg(const ByteImage& picture, std::vector<unsigned char>& encoded) {
  const auto encoder = std::make_unique<JpegEncoder>();
  if (!encoder->write(picture)) return encoder->failure.message;
  encoded.assign(encoder->bytes, encoder->bytes + encoder->count);
  return "";
}

}  // namespace emberline
