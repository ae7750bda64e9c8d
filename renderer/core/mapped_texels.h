// The texels of one image in a memory-mapped file (io/image/texture_store.h), and their order in
// that file.
//
// The image is stored as tiles of kTileSide x kTileSide texels, row by row, so that a page of
// memory holds texels that are used together. With 4-byte texels, a tile takes one page, whereas a
// row of 4096 texels would take four.
//
// Reading a page that is not in memory blocks the thread until the disk delivers it. Code that
// looks up many texels prefetches all of them first, so that the disk reads them concurrently.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>

namespace emberline {

inline constexpr int kTileSide = 32;

// Returns the index of a texel in the file. Tiles are cut off at the right and bottom edges, so
// there is no padding. In an image of 40 x 35, texel (33, 34) is in the last tile, which has 3 rows
// of 8 texels and starts at index 32 * 40 + 3 * 32; its index within the tile is 2 * 8 + 1.
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
  // Prefetches the block of kPrefetchBytes that contains this byte. Does not wait.
  void prefetch(size_t byte) const {
    if (!prefetched_[byte / kPrefetchBytes].load(std::memory_order_relaxed))
      prefetch_part(byte / kPrefetchBytes);
  }
  // Frees the memory of all pages. A page is read again when it is accessed.
  void release_pages() const;

 private:
  // Bytes prefetched by one request.
  static constexpr size_t kPrefetchBytes = size_t(1) << 16;

  void prefetch_part(size_t part) const;

  std::shared_ptr<const std::byte> texels_;
  size_t size_;
  std::unique_ptr<std::atomic<bool>[]> prefetched_;  // whether each block was prefetched after the
                                                     // last release_pages()
};

}  // namespace emberline
