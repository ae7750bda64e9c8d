#include "io/image/codecs.h"

#include <cassert>
#include <cmath>
#include <cstring>

namespace emberline {
namespace {

// Rows of these widths may be run-length encoded. An encoded row starts with its width.
constexpr int kMinCodedWidth = 8, kMaxCodedWidth = 0x7fff;

constexpr const char* kTruncated = "it is truncated";

class HdrDecoder final : public ImageDecoder {
 public:
  HdrDecoder(const ByteSource& source, const ImageHeader& header)
      : cursor_(source), row_(4 * size_t(header.width)) {
    cursor_.seek(header.pixel_offset);
    set_layout(int(header.width), int(header.height), {"R", "G", "B"}, SampleType::kFloat);
  }

  std::string read(const Rect& pixels, int first, int last, [[maybe_unused]] SampleType type,
                   std::byte* out, size_t row) override {
    assert(type == SampleType::kFloat && pixels.width() == layout_.width);
    for (int y = pixels.y0; y < pixels.y1; ++y, out += row) {
      if (const char* error = read_row()) return error;
      std::byte* to = out;
      for (const uint8_t* pixel = row_.data(); pixel < row_.data() + row_.size(); pixel += 4) {
        const float unit = pixel[3] == 0 ? 0.0f : std::ldexp(1.0f, pixel[3] - (128 + 8));
        for (int c = first; c < last; ++c, to += sizeof(float)) {
          const float value = float(pixel[c]) * unit;
          std::memcpy(to, &value, sizeof value);
        }
      }
    }
    return "";
  }

 private:
  // Reads exactly `count` bytes, or returns false.
  bool take(uint8_t* bytes, size_t count) { return cursor_.take(bytes, count) == count; }

  // Returns null on success, or the error.
  const char* read_row() {
    if (!take(row_.data(), 4)) return kTruncated;
    const bool coded = layout_.width >= kMinCodedWidth && layout_.width <= kMaxCodedWidth &&
                       row_[0] == 2 && row_[1] == 2 && row_[2] < 128;
    if (!coded) return take(row_.data() + 4, row_.size() - 4) ? nullptr : kTruncated;
    if ((row_[2] << 8 | row_[3]) != layout_.width) return "a row has the wrong width";
    for (size_t channel = 0; channel < 4; ++channel) {
      if (const char* error = read_channel(channel)) return error;
    }
    return nullptr;
  }

  // Reads one byte of each pixel. These bytes are stored as runs of identical bytes and as literal
  // bytes.
  const char* read_channel(size_t channel) {
    uint8_t values[128];
    for (size_t at = channel; at < row_.size();) {
      uint8_t count = 0;
      if (!take(&count, 1)) return kTruncated;
      const bool run = count > 128;
      const size_t length = run ? count - 128u : count;
      if (length == 0 || length > (row_.size() - at + 3) / 4) return "a run extends beyond its row";
      if (!take(values, run ? 1 : length)) return kTruncated;
      for (size_t i = 0; i < length; ++i, at += 4) row_[at] = values[run ? 0 : i];
    }
    return nullptr;
  }

  ByteCursor cursor_;
  std::vector<uint8_t> row_;  // four bytes per pixel
};

}  // namespace

std::unique_ptr<ImageDecoder> open_hdr(const ByteSource& source, const ImageHeader& header) {
  return std::make_unique<HdrDecoder>(source, header);
}

}  // namespace emberline
