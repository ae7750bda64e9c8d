// Reads the buffers of a glTF file on demand, since a scene may use only a little of a large
// buffer.
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
  GltfBuffer() = default;
  // Makes a buffer in memory, from a data URI.
  explicit GltfBuffer(std::vector<uint8_t> bytes)
      : bytes_(std::move(bytes)), size_(bytes_.size()) {}
  // Makes a buffer of `size` bytes from `offset` of a file. The range must lie inside the file.
  GltfBuffer(InputFile file, uint64_t offset, uint64_t size)
      : file_(std::move(file)), offset_(offset), size_(size) {}

  uint64_t size() const { return size_; }
  void shrink(uint64_t size) { size_ = size; }  // `size` must not exceed size()

  // Returns the bytes [begin, end), which must lie in the buffer. The bytes are valid until
  // forget() or the end of the buffer's lifetime. Thread-safe. Throws InputError if the bytes
  // cannot be read or exceed the memory budget, and throws Cancelled.
  ByteSpan bytes(uint64_t begin, uint64_t end, const LoadProgress& progress);
  // Copies the bytes to `out`. If some are not loaded yet, reads all of them directly into `out`,
  // in parallel.
  void copy(uint64_t begin, uint64_t end, void* out, const LoadProgress& progress);
  // Drops loaded file data. It is read again when needed.
  void forget();

 private:
  bool is_loaded(uint64_t begin, uint64_t end);  // whether all bytes of the range are loaded

  std::vector<uint8_t> bytes_;
  std::optional<InputFile> file_;
  uint64_t offset_ = 0, size_ = 0;
  std::mutex mutex_;
  ZeroedArray<uint8_t> memory_;  // the whole buffer; pages that were never read take no memory
  std::map<uint64_t, uint64_t> loaded_ranges_;  // disjoint; maps begin to end
  MemoryReservation reserved_;
};

}  // namespace emberline
