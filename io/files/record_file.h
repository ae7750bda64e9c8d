// Files of records, such as the checkpoint of an unfinished frame (renderer/output/checkpoint.h):
//
// clang-format off
//   "EMBRECF\n", u32 format = 1, u32 bytes of the head, u64 checksum of the head; the head (JSON)
//   any number of: "EMBR", u32 kind, u64 number, u64 bytes unpacked, u64 bytes packed,
//                  u64 checksum of the packed bytes, u64 checksum of the 40 bytes before;
//                  the bytes, packed by zstd
// clang-format on
//
// Numbers are little-endian. Checksums are computed with io/files/fingerprint.h. A record is
// appended in one piece, so a crash leaves at most one incomplete record, at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/input_file.h"

namespace emberline {

struct RecordEntry {
  uint32_t kind = 0;
  uint64_t number = 0;
  uint64_t bytes = 0;  // unpacked size
  uint64_t packed = 0, checksum = 0;
  uint64_t offset = 0;  // offset of the packed bytes
};

std::string pack_file_head(std::string_view head);
// Whether the file exists and starts with this format's magic number.
bool is_record_file(const std::string& path);
// Thread-safe. Packs a few hundred megabytes per second.
std::string pack_record(uint32_t kind, uint64_t number, std::span<const std::byte> bytes);

// Reads an existing file. Reading is thread-safe.
class RecordFile {
 public:
  // Reads the head and each record's header. Throws InputError if the file has another format, a
  // later version or a damaged head.
  explicit RecordFile(const std::string& path);

  const std::string& head() const { return head_; }
  const std::string& path() const { return file_.place(); }
  // The intact records before the first record that is damaged or incomplete.
  std::span<const RecordEntry> records() const { return records_; }
  uint64_t end() const { return end_; }                  // the end of the last intact record
  bool has_more() const { return end_ < file_.size(); }  // whether more bytes follow
  // Throws InputError if the record is damaged or unpacks to more than `most` bytes.
  std::vector<std::byte> read(const RecordEntry& record, uint64_t most) const;
  // Verifies the checksum of the packed bytes without unpacking them.
  bool is_intact(const RecordEntry& record) const;

 private:
  InputFile file_;
  std::string head_;
  std::vector<RecordEntry> records_;
  uint64_t end_ = 0;

  // Returns the packed bytes. Throws InputError if their checksum is wrong.
  std::string read_packed(const RecordEntry& record) const;
};

}  // namespace emberline
