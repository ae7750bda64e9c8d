// The bytes behind a glTF file's buffers, read as far as they are asked for: of a buffer of
// gigabytes a scene may use little.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "io/files/input_file.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/zeroed_array.h"

namespace emberline {

using ByteSpan = std::span<const uint8_t>;

class GltfBuffer {
 public:
  // Of nothing: the placeholder that decoders without meshopt would need.
  GltfBuffer() = default;
  // Bytes at hand, of a data URI.
  explicit GltfBuffer(std::vector<uint8_t> bytes)
      : bytes_(std::move(bytes)), size_(bytes_.size()) {}
  // The `size` bytes of a file from `offset` on, which lie in it.
  GltfBuffer(InputFile file, uint64_t offset, uint64_t size)
      : file_(std::move(file)), offset_(offset), size_(size) {}

  uint64_t size() const { return size_; }
  void shrink(uint64_t size) { size_ = size; }  // at most size()

  // Bytes [begin, end), which lie in the buffer; valid as long as it lives. Thread-safe. Throws
  // InputError where they cannot be read, or the budget does not allow it; Cancelled.
  ByteSpan bytes(uint64_t begin, uint64_t end, const LoadProgress& progress);
  // The same, copied to `out`: what is not there yet is read to that place alone, by all threads.
  void copy(uint64_t begin, uint64_t end, void* out, const LoadProgress& progress);
  // Lets go what was read of a file: it is read again if it is asked for again.
  void forget();

 private:
  bool has(uint64_t begin, uint64_t end);  // a part that is there already

  std::vector<uint8_t> bytes_;
  std::optional<InputFile> file_;
  uint64_t offset_ = 0, size_ = 0;
  std::mutex mutex_;
  ZeroedArray<uint8_t> memory_;           // of the whole buffer: what is not read takes no room
  std::map<uint64_t, uint64_t> present_;  // disjoint ranges of it that are there: begin to end
  MemoryReservation reserved_;
};

}  // namespace emberline
