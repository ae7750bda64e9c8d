#include "io/image/ktx2/block_rows.h"

#include <zstd.h>

#include <algorithm>
#include <bit>
#include <new>
#include <optional>
#include <vector>

#include "io/files/byte_order.h"
#include "io/image/ktx2/basis_lz.h"
#include "io/image/ktx2/bit_reader.h"

namespace emberline::ktx2 {
namespace {

class Etc1sRows final : public BlockRows {
 public:
  Etc1sRows(const Container& container, const std::string& place)
      : header_(read_basis_lz_header(container, place)),
        tables_(read_basis_lz_tables(header_, place)),
        colour_(tables_, header_.slices[0], size_t(container.blocks_across()), place) {
    if (!container.has_second_slice) return;
    alpha_.emplace(tables_, header_.slices[1], size_t(container.blocks_across()), place);
  }

  void next(std::span<BlockPixels> row) override {
    const std::span<const SliceReader::Block> colours = colour_.next_row();
    std::span<const SliceReader::Block> alphas;
    if (alpha_) alphas = alpha_->next_row();
    for (size_t x = 0; x < row.size(); ++x) {
      const EtcPixels colour = decode(colours[x]);
      for (size_t i = 0; i < colour.size(); ++i) {
        row[x][i] = {colour[i][0], colour[i][1], colour[i][2], 255};
      }
      if (!alpha_) continue;
      // Alpha is the green channel of the second slice, as in the reference transcoder. The
      // channels of that slice can differ, since alpha and colour share a palette of endpoints.
      const EtcPixels alpha = decode(alphas[x]);
      for (size_t i = 0; i < alpha.size(); ++i) row[x][i][3] = alpha[i][1];
    }
  }

 private:
  EtcPixels decode(const SliceReader::Block& block) const {
    return decode_etc1s(tables_.endpoints[block.endpoint], tables_.selectors[block.selector]);
  }

  const BasisLzHeader header_;
  const BasisLzTables tables_;
  SliceReader colour_;
  std::optional<SliceReader> alpha_;
};

// Decodes UASTC blocks that are not supercompressed.
class UncompressedRows final : public BlockRows {
 public:
  explicit UncompressedRows(Bytes blocks) : unread_(blocks) {}

  void next(std::span<BlockPixels> row) override {
    for (BlockPixels& pixels : row) {
      pixels = decode_uastc(unread_.first<kUastcBlockBytes>());
      unread_ = unread_.subspan(kUastcBlockBytes);
    }
  }

 private:
  Bytes unread_;
};

// Returns the size of a Zstandard frame's window, which the decoder keeps in memory (RFC 8878,
// 3.1.1.1). Returns 0 if `frame` is not a Zstandard frame.
uint64_t zstd_window(Bytes frame) {
  if (frame.size() < 6 || little_endian(frame, 0, 4) != ZSTD_MAGICNUMBER) return 0;
  const uint8_t descriptor = frame[4];
  const bool is_single_segment = (descriptor & 0x20) != 0;
  if (!is_single_segment) {
    const uint64_t base = uint64_t(1) << (10 + (frame[5] >> 3));
    return base + base / 8 * (frame[5] & 7);
  }
  constexpr std::array<size_t, 4> kIdBytes = {0, 1, 2, 4}, kSizeBytes = {1, 2, 4, 8};
  const size_t bytes = kSizeBytes[descriptor >> 6], at = 5 + kIdBytes[descriptor & 3];
  if (frame.size() < at + bytes) return 0;
  return little_endian<uint64_t>(frame, at, bytes) + (bytes == 2 ? 256 : 0);
}

// Base-2 logarithms of Zstandard's smallest window and of the largest window that its decoder
// accepts by default.
constexpr int kMinWindowLog = 10, kMaxWindowLog = 27;

uint64_t checked_window(const Container& container, const std::string& place) {
  const uint64_t window = zstd_window(container.level);
  if (window == 0 || window > uint64_t(1) << kMaxWindowLog) {
    throw_damaged(place,
                  "has a level that is not a Zstandard frame with a window of at most 128 MiB");
  }
  return window;
}

class ZstdRows final : public BlockRows {
 public:
  ZstdRows(const Container& container, const std::string& place)
      : place_(place),
        stream_(ZSTD_createDStream()),
        packed_{container.level.data(), container.level.size(), 0},
        blocks_(size_t(container.blocks_across()) * kUastcBlockBytes) {
    if (!stream_) throw std::bad_alloc();
    // A level may have several frames, but block_rows_bytes() counts only the first frame's window.
    // So no later frame may have a larger one.
    const int log = int(std::bit_width(checked_window(container, place) - 1));
    ZSTD_DCtx_setParameter(stream_.get(), ZSTD_d_windowLogMax, std::max(kMinWindowLog, log));
  }

  void next(std::span<BlockPixels> row) override {
    ZSTD_outBuffer unpacked = {blocks_.data(), blocks_.size(), 0};
    while (unpacked.pos < unpacked.size) {
      const size_t before = unpacked.pos + packed_.pos;
      const size_t result = ZSTD_decompressStream(stream_.get(), &unpacked, &packed_);
      if (ZSTD_isError(result)) {
        throw_damaged(place_, std::string("does not decompress: ") + ZSTD_getErrorName(result));
      }
      if (unpacked.pos + packed_.pos == before) {
        throw_damaged(place_, "has a truncated level");
      }
    }
    UncompressedRows(blocks_).next(row);
  }

 private:
  struct Free {
    void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
  };
  const std::string place_;
  std::unique_ptr<ZSTD_DStream, Free> stream_;
  ZSTD_inBuffer packed_;
  std::vector<uint8_t> blocks_;  // the blocks of one row
};

}  // namespace

uint64_t block_rows_bytes(const Container& container, const std::string& place) {
  const uint64_t across = uint64_t(container.blocks_across());
  if (container.codec == Codec::kEtc1s) {
    constexpr uint64_t kTables = uint64_t(1) << 18;  // seven Huffman tables and the history
    const uint64_t slice = across * (sizeof(SliceReader::Block) + 3);
    return kTables + read_basis_lz_header(container, place).decoded_bytes() + 2 * slice;
  }
  if (!container.is_zstd) return 0;
  constexpr uint64_t kState = uint64_t(1) << 20;  // with 128 KiB buffers for input and output
  return checked_window(container, place) + kState + across * kUastcBlockBytes;
}

std::unique_ptr<BlockRows> make_block_rows(const Container& container, const std::string& place) {
  if (container.codec == Codec::kEtc1s) return std::make_unique<Etc1sRows>(container, place);
  if (container.is_zstd) return std::make_unique<ZstdRows>(container, place);
  return std::make_unique<UncompressedRows>(container.level);
}

}  // namespace emberline::ktx2
