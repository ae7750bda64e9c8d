// Texels of one image in a mapped file (io/image/texture_store.h), and the order in which they lie
// there.
//
// Order: squares of kTileSide, one row of squares after the other, so that a page of memory holds
// what a surface shows together. A row of 4096 texels of 4 bytes is four pages; a square is one.
//
// Reading a page that is not in memory stops the thread until the disk has it. Who looks up many
// texels asks for all of them first: then the disk works on all of them at once.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>

namespace emberline {

inline constexpr int kTileSide = 32;

// The squares at the right and the bottom are cut off, so there is no padding: in an image of 40 x
// 35, texel (33, 34) is the second of the last of three rows of 8, which follow 32 * 40 + 3 * 32
// texels.
inline size_t tiled_index(int width, int height, int x, int y) {
  const int left = x & ~(kTileSide - 1), top = y & ~(kTileSide - 1);
  const int columns = std::min(kTileSide, width - left), rows = std::min(kTileSide, height - top);
  return size_t(top) * size_t(width) + size_t(left) * size_t(rows) +
         size_t(y - top) * size_t(columns) + size_t(x - left);
}

// Thread-safe.
class MappedTexels {
 public:
  MappedTexels(std::shared_ptr<const std::byte> texels, size_t size);

  const std::byte* data() const { return texels_.get(); }
  // Has the page of that byte, and some around it, read from the file if need be. Does not wait.
  void ask_for(size_t byte) const {
    if (!asked_[byte / kPart].load(std::memory_order_relaxed)) ask_for_part(byte / kPart);
  }
  // The process's share of the memory they are in.
  void let_go() const;

 private:
  // What is asked for at once.
  static constexpr size_t kPart = size_t(1) << 16;

  void ask_for_part(size_t part) const;

  std::shared_ptr<const std::byte> texels_;
  size_t size_;
  std::unique_ptr<std::atomic<bool>[]> asked_;  // of each part, since they were let go
};

}  // namespace emberline
