#include "io/files/record_file.h"

#include <zstd.h>

#include <bit>
#include <cstring>

#include "io/files/fingerprint.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kFileMagic[8] = {'E', 'M', 'B', 'R', 'E', 'C', 'F', '\n'};
constexpr char kRecordMagic[4] = {'E', 'M', 'B', 'R'};
constexpr uint32_t kFormatVersion = 1;
constexpr uint64_t kMaxHeadBytes = uint64_t(16)
                                   << 20;  // a frame's head contains its Cryptomatte names
constexpr int kCompressionLevel = 1;       // zstd's fastest level; halves the size at disk speed

struct FileHeader {
  char magic[8];
  uint32_t format, head_bytes;
  uint64_t head_checksum;
};
static_assert(sizeof(FileHeader) == 24);

struct RecordHeader {
  char magic[4];
  uint32_t kind;
  uint64_t number, bytes, packed, checksum;
  uint64_t own_checksum;

  uint64_t expected_checksum() const {
    return fingerprint(std::string_view(magic, sizeof(RecordHeader) - sizeof own_checksum));
  }
};
static_assert(sizeof(RecordHeader) == 48);

template <typename Start>
std::string_view bytes_of(const Start& start) {
  return {reinterpret_cast<const char*>(&start), sizeof start};
}

InputError damage_error(const std::string& path) {
  return InputError(path, "the checkpoint is damaged");
}

}  // namespace

std::string pack_file_head(std::string_view head) {
  if (head.size() > kMaxHeadBytes) {
    throw RenderError(
        "a checkpoint's header can hold {} MiB, but this frame needs {} MiB; render without "
        "`cryptomatte` or without a checkpoint",
        kMaxHeadBytes >> 20, (head.size() >> 20) + 1);
  }
  FileHeader start = {{}, kFormatVersion, uint32_t(head.size()), fingerprint(head)};
  std::memcpy(start.magic, kFileMagic, sizeof kFileMagic);
  return std::string(bytes_of(start)).append(head);
}

bool is_record_file(const std::string& path) {
  const auto file = InputFile::try_open(path);
  char magic[sizeof kFileMagic];
  if (!file || file->size() < sizeof magic) return false;
  file->read(0, sizeof magic, magic);
  return std::memcmp(magic, kFileMagic, sizeof magic) == 0;
}

std::string pack_record(uint32_t kind, uint64_t number, std::span<const std::byte> bytes) {
  std::string record(sizeof(RecordHeader) + ZSTD_compressBound(bytes.size()), '\0');
  char* packed = record.data() + sizeof(RecordHeader);
  const size_t size = ZSTD_compress(packed, record.size() - sizeof(RecordHeader), bytes.data(),
                                    bytes.size(), kCompressionLevel);
  if (ZSTD_isError(size)) throw std::bad_alloc();  // no other error is possible
  record.resize(sizeof(RecordHeader) + size);
  RecordHeader start = {{}, kind, number, bytes.size(), size, fingerprint({packed, size}), 0};
  std::memcpy(start.magic, kRecordMagic, sizeof kRecordMagic);
  start.own_checksum = start.expected_checksum();
  std::memcpy(record.data(), &start, sizeof start);
  return record;
}

RecordFile::RecordFile(const std::string& path) : file_(path) {
  FileHeader start;
  const bool whole = file_.size() >= sizeof start;
  if (whole) file_.read(0, sizeof start, &start);
  if (!whole || std::memcmp(start.magic, kFileMagic, sizeof kFileMagic) != 0) {
    throw InputError(path, "it is not an Emberline checkpoint");
  }
  if (start.format != kFormatVersion) {
    throw InputError(path, "its checkpoint format is {}; this version reads {}", start.format,
                     kFormatVersion);
  }
  if (start.head_bytes > std::min(kMaxHeadBytes, file_.size() - sizeof start)) {
    throw InputError(path, "the checkpoint is damaged or truncated");
  }
  head_.resize(start.head_bytes);
  file_.read(sizeof start, head_.size(), head_.data());
  if (fingerprint(head_) != start.head_checksum) throw damage_error(path);
  end_ = sizeof start + head_.size();
  while (file_.size() - end_ >= sizeof(RecordHeader)) {
    RecordHeader record;
    file_.read(end_, sizeof record, &record);
    const uint64_t offset = end_ + sizeof record;
    const bool is_valid = std::memcmp(record.magic, kRecordMagic, sizeof kRecordMagic) == 0 &&
                          record.own_checksum == record.expected_checksum();
    if (!is_valid || record.packed > file_.size() - offset) break;
    records_.push_back(
        {record.kind, record.number, record.bytes, record.packed, record.checksum, offset});
    end_ = offset + record.packed;
  }
}

std::string RecordFile::read_packed(const RecordEntry& record) const {
  if (record.packed > ZSTD_compressBound(record.bytes)) throw damage_error(path());
  std::string packed(record.packed, '\0');
  file_.read(record.offset, packed.size(), packed.data());
  if (fingerprint(packed) != record.checksum) throw damage_error(path());
  return packed;
}

bool RecordFile::is_intact(const RecordEntry& record) const {
  try {
    read_packed(record);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::vector<std::byte> RecordFile::read(const RecordEntry& record, uint64_t most) const {
  if (record.bytes > most) throw damage_error(path());
  const std::string packed = read_packed(record);
  std::vector<std::byte> bytes(record.bytes);
  const size_t size = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) || size != bytes.size()) throw damage_error(path());
  return bytes;
}

}  // namespace emberline
