#include "io/image/ktx2/ktx2.h"

#include <cassert>
#include <string_view>
#include <vector>

#include "io/image/encoded_image.h"
#include "io/image/ktx2/block_rows.h"
#include "io/image/ktx2/container.h"

namespace emberline {
namespace {

using ktx2::kBlockSide;

class Ktx2Decoder final : public ImageDecoder {
 public:
  Ktx2Decoder(std::span<const uint8_t> bytes, const std::string& place)
      : container_(ktx2::read_container(bytes, place)),
        rows_(ktx2::make_block_rows(container_, place)),
        blocks_(size_t(container_.blocks_across())) {
    constexpr const char* kNames[] = {"R", "G", "B", "A"};
    const int channels = container_.channels;
    set_layout(int(container_.width), int(container_.height), {kNames, kNames + channels},
               SampleType::kUint8);
    layout_.alpha_channel = channels == 4 ? 3 : -1;
  }

  std::string attribute(const char* name) const override {
    if (std::string_view(name) != kTransferAttribute) return "";
    return container_.is_srgb ? "sRGB" : "linear";
  }

  std::string read(const Rect& pixels, [[maybe_unused]] int first, [[maybe_unused]] int last,
                   [[maybe_unused]] SampleType type, std::byte* out, size_t row) override {
    assert(first == 0 && last == container_.channels && type == SampleType::kUint8);
    assert(pixels.x0 == 0 && pixels.x1 == layout_.width);
    for (int y = pixels.y0; y < pixels.y1; ++y, out += row) {
      // Rows of pixels are requested in order, but the pixels of one row of blocks may be requested
      // in parts.
      for (; rows_read_ <= y / kBlockSide; ++rows_read_) rows_->next(blocks_);
      write_row(y % kBlockSide, out);
    }
    return "";
  }

 private:
  void write_row(int y, std::byte* out) const {
    const size_t channels = size_t(container_.channels);
    for (size_t x = 0; x < size_t(container_.width); ++x) {
      const auto& pixel = blocks_[x / kBlockSide][size_t(y * kBlockSide) + x % kBlockSide];
      for (size_t c = 0; c < channels; ++c) {
        const int source = container_.sources[c];
        *out++ = source < 0 ? std::byte(0) : std::byte(pixel[size_t(source)]);
      }
    }
  }

  const ktx2::Container container_;
  std::unique_ptr<ktx2::BlockRows> rows_;
  std::vector<ktx2::BlockPixels> blocks_;  // the current row of blocks
  int rows_read_ = 0;                      // number of rows of blocks read so far
};

}  // namespace

ImageHeader read_ktx2_header(std::span<const uint8_t> bytes, const std::string& place) {
  const ktx2::Container container = ktx2::read_container(bytes, place);
  ImageHeader header;
  header.width = container.width;
  header.height = container.height;
  check_pixels_plausible(header, container.level.size(), place);
  header.tile_bytes = ktx2::block_rows_bytes(container, place) +
                      uint64_t(container.blocks_across()) * sizeof(ktx2::BlockPixels);
  return header;
}

std::unique_ptr<ImageDecoder> open_ktx2(std::span<const uint8_t> bytes, const std::string& place) {
  return std::make_unique<Ktx2Decoder>(bytes, place);
}

}  // namespace emberline
