#include "io/image/ktx2/container.h"

#include <algorithm>
#include <bit>
#include <string_view>

#include "io/files/byte_order.h"
#include "io/image/ktx2/bit_reader.h"
#include "renderer/core/memory_budget.h"

namespace emberline::ktx2 {
namespace {

// Section 2: the header and the index together have 80 bytes. An entry of the level index has
// 24 bytes.
constexpr size_t kHeaderBytes = 80, kLevelEntry = 24;
enum Supercompression : uint32_t { kNone = 0, kBasisLz = 1, kZstandard = 2 };  // section 3.8
// Khronos Data Format Specification 1.4, sections 4 and 5: a basic block has 24 bytes, plus
// 16 bytes per sample.
constexpr size_t kDescriptorBytes = 24, kSampleBytes = 16;
constexpr uint32_t kModelEtc1s = 163, kModelUastc = 166;
constexpr uint32_t kTransferLinear = 1, kTransferSrgb = 2;
constexpr uint32_t kFlagPremultiplied = 1;

class ContainerReader {
 public:
  ContainerReader(Bytes file, const std::string& place) : file_(file), place_(place) {}

  Container read() {
    if (file_.size() < kHeaderBytes) throw_damaged(place_, "is truncated in its header");
    read_header();
    read_descriptor();
    check_key_values();
    read_levels();
    return container_;
  }

 private:
  uint32_t word(size_t offset) const { return little_endian(file_, offset, 4); }
  uint64_t long_word(size_t offset) const { return little_endian<uint64_t>(file_, offset, 8); }

  // Returns a range of the file, which must lie after the header.
  Bytes part(uint64_t offset, uint64_t length, const char* name) const {
    if (offset < kHeaderBytes || offset > file_.size() || length > file_.size() - offset) {
      throw_damaged(place_, std::string("has its ") + name + " outside the file");
    }
    return file_.subspan(size_t(offset), size_t(length));
  }

  [[noreturn]] void throw_unsupported(const std::string& what) const {
    throw InputError(place_, "KTX 2 with {} is not supported", what);
  }

  void read_header() {
    const uint32_t vk_format = word(12), depth = word(28), layers = word(32), faces = word(36);
    container_.width = word(20);
    container_.height = word(24);
    levels_ = word(40);
    supercompression_ = word(44);
    if (vk_format != 0) {
      throw_unsupported("a GPU format (VkFormat " + std::to_string(vk_format) +
                        "; use ETC1S or UASTC)");
    }
    if (depth != 0 || layers != 0 || faces != 1)
      throw_unsupported("several layers, faces or slices");
    if (container_.width == 0 || container_.height == 0) throw_damaged(place_, "is empty");
    // Section 3.7: the levels may go down to a single pixel.
    const uint64_t max_levels =
        uint64_t(std::bit_width(uint64_t(std::max(container_.width, container_.height))));
    if (levels_ == 0 || levels_ > max_levels) {
      throw_damaged(place_, "has " + std::to_string(levels_) + " levels");
    }
  }

  // See section 3.10 of the KTX specification, and section 5 of the Data Format Specification.
  void read_descriptor() {
    const Bytes data = part(word(48), word(52), "data format descriptor");
    const auto at = [&](size_t offset) { return little_endian(data, offset, 4); };
    const auto byte = [&](size_t offset) { return uint32_t(data[offset]); };
    if (data.size() < 4 + kDescriptorBytes || at(0) != data.size() || at(4) != 0) {
      throw_damaged(place_, "has no basic data format descriptor");
    }
    const size_t size = at(8) >> 16;
    if (size < kDescriptorBytes + kSampleBytes || size > data.size() - 4) {
      throw_damaged(place_, "has no samples in its data format descriptor");
    }
    const size_t samples = (size - kDescriptorBytes) / kSampleBytes;
    const uint32_t model = byte(12), transfer = byte(14);
    const auto channel = [&](size_t sample) {
      return byte(4 + kDescriptorBytes + sample * kSampleBytes + 3) & 15;
    };
    if (model == kModelEtc1s && supercompression_ == kBasisLz) {
      container_.codec = Codec::kEtc1s;
    } else if (model == kModelUastc &&
               (supercompression_ == kNone || supercompression_ == kZstandard)) {
      container_.codec = Codec::kUastc;
      container_.is_zstd = supercompression_ == kZstandard;
    } else {
      throw_unsupported("colour model " + std::to_string(model) + " and supercompression " +
                        std::to_string(supercompression_) +
                        " (use ETC1S with BasisLZ, or UASTC uncompressed or with Zstandard)");
    }
    if (transfer != kTransferLinear && transfer != kTransferSrgb) {
      throw_unsupported("the transfer function " + std::to_string(transfer));
    }
    container_.is_srgb = transfer == kTransferSrgb;
    if ((byte(15) & kFlagPremultiplied) != 0) throw_unsupported("premultiplied alpha");
    if (at(16) != 0x0303) throw_damaged(place_, "has blocks that are not 4 x 4 pixels");
    if (samples == 1) {
      read_channels(channel(0), -1);
    } else if (samples == 2) {
      read_channels(channel(0), int(channel(1)));
    } else {
      throw_unsupported(std::to_string(samples) + " samples");
    }
  }

  // These are the tables of KHR_DF_CHANNEL_* in section 3.10.3.
  void read_channels(uint32_t first, int second) {
    struct Row {
      Codec codec;
      uint32_t first;
      int second;
      int channels;
      std::array<int, 4> sources;
    };
    constexpr std::array<Row, 9> kRows = {{
        {Codec::kEtc1s, 0, -1, 3, {0, 1, 2, -1}},    // RGB
        {Codec::kEtc1s, 0, 15, 4, {0, 1, 2, 3}},     // RGB, AAA
        {Codec::kEtc1s, 3, -1, 1, {0, -1, -1, -1}},  // RRR
        {Codec::kEtc1s, 3, 4, 3, {0, 3, -1, -1}},    // RRR, GGG
        {Codec::kUastc, 0, -1, 3, {0, 1, 2, -1}},    // RGB
        {Codec::kUastc, 3, -1, 4, {0, 1, 2, 3}},     // RGBA
        {Codec::kUastc, 4, -1, 1, {0, -1, -1, -1}},  // RRR
        {Codec::kUastc, 5, -1, 3, {0, 3, -1, -1}},   // RRRG
        {Codec::kUastc, 6, -1, 3, {0, 1, -1, -1}},   // RG
    }};
    for (const Row& row : kRows) {
      if (row.codec != container_.codec || row.first != first || row.second != second) continue;
      container_.channels = row.channels;
      container_.sources = row.sources;
      container_.has_second_slice = row.second >= 0;
      return;
    }
    throw_unsupported("the channels " + std::to_string(first) +
                      (second >= 0 ? " and " + std::to_string(second) : ""));
  }

  // See section 3.11. KHR_texture_basisu requires the default values.
  void check_key_values() const {
    if (word(60) == 0) return;
    const Bytes data = part(word(56), word(60), "key/value data");
    for (size_t offset = 0; data.size() - offset >= 4;) {
      const uint64_t length = little_endian(data, offset, 4);
      offset += 4;
      if (length > data.size() - offset) throw_damaged(place_, "has a truncated key/value entry");
      const std::string_view text(reinterpret_cast<const char*>(data.data() + offset),
                                  size_t(length));
      const size_t end = std::min(text.find('\0'), text.size());
      const std::string_view key = text.substr(0, end);
      std::string_view value = text.substr(std::min(end + 1, text.size()));
      value = value.substr(0, value.find('\0'));
      if (key == "KTXswizzle" && value != "rgba") throw_unsupported("swizzled channels");
      if (key == "KTXorientation" && value != "rd")
        throw_unsupported("an orientation other than top-left");
      offset = std::min(offset + size_t(length + 3) / 4 * 4, data.size());
    }
  }

  // See section 3.9. Checks all levels, although only the first is decoded.
  void read_levels() {
    container_.levels = int(levels_);
    if (levels_ * kLevelEntry > file_.size() - kHeaderBytes) {
      throw_damaged(place_, "is truncated in its level index");
    }
    const bool is_basis = container_.codec == Codec::kEtc1s;
    for (size_t i = 0; i < levels_; ++i) {
      const size_t entry = kHeaderBytes + i * kLevelEntry;
      const Bytes level = part(long_word(entry), long_word(entry + 8), "levels");
      const auto blocks = [&](int64_t side) {
        return uint64_t(std::max<int64_t>(side >> i, 1) + kBlockSide - 1) / kBlockSide;
      };
      const uint64_t unpacked =
          is_basis
              ? 0
              : bytes_of(blocks(container_.width) * blocks(container_.height), kUastcBlockBytes);
      const bool is_plain = supercompression_ == kNone;
      if (level.empty() || long_word(entry + 16) != unpacked ||
          (is_plain && level.size() != unpacked)) {
        throw_damaged(place_, "has the wrong size for level " + std::to_string(i));
      }
      container_.level_bytes[i] = level.size();
      if (i == 0) container_.level = level;
    }
    const uint64_t global_bytes = long_word(72);
    if (is_basis) {
      container_.global_data = part(long_word(64), global_bytes, "global data");
    } else if (global_bytes != 0) {
      throw_damaged(place_, "has unused global data");
    }
  }

  const Bytes file_;
  const std::string& place_;
  Container container_;
  uint64_t levels_ = 0;
  uint32_t supercompression_ = 0;
};

}  // namespace

Container read_container(Bytes file, const std::string& place) {
  return ContainerReader(file, place).read();
}

}  // namespace emberline::ktx2
