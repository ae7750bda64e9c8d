// Files of records: what a frame is kept in until it is done (renderer/output/checkpoint.h).
//
//   "EMBRECF\n", u32 format = 1, u32 bytes of the head, u64 checksum of the head; the head, a JSON
//   text any number of: "EMBR", u32 kind, u64 number, u64 bytes unpacked, u64 bytes packed,
//                  u64 checksum of the packed bytes, u64 checksum of the 40 bytes before;
//                  the bytes, packed by zstd
//
// Numbers are little-endian, checksums those of io/files/fingerprint.h. A record is appended in one
// piece: a file that a crash has cut short ends in a part of one, and all before it holds.
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
  uint64_t bytes = 0;  // unpacked
  uint64_t packed = 0, checksum = 0;
  uint64_t offset = 0;  // of the packed bytes
};

std::string record_file_head(std::string_view head);
// Whether a file that is there begins as these do.
bool is_record_file(const std::string& path);
// Any thread; packing runs at some hundred megabytes a second.
std::string packed_record(uint32_t kind, uint64_t number, std::span<const std::byte> bytes);

// One that is there. Reading is thread-safe.
class RecordFile {
 public:
  // Reads the head, and what stands before each record. Throws InputError for a file that is not
  // one, is of a later format, or whose head is damaged.
  explicit RecordFile(const std::string& path);

  const std::string& head() const { return head_; }
  const std::string& path() const { return file_.place(); }
  // Those before the first place that is not one.
  std::span<const RecordEntry> records() const { return records_; }
  uint64_t end() const { return end_; }                  // of these
  bool has_more() const { return end_ < file_.size(); }  // behind them
  // Throws InputError for one that is damaged or would take more than `most` bytes.
  std::vector<std::byte> read(const RecordEntry& record, uint64_t most) const;
  // Whether the packed bytes have their checksum. Unpacks nothing.
  bool is_whole(const RecordEntry& record) const;

 private:
  InputFile file_;
  std::string head_;
  std::vector<RecordEntry> records_;
  uint64_t end_ = 0;

  // The packed bytes; throws InputError where their checksum is another.
  std::string read_packed(const RecordEntry& record) const;
};

}  // namespace emberline
