#include "renderer/core/mapped_texels.h"

#include <sys/mman.h>

namespace emberline {

MappedTexels::MappedTexels(std::shared_ptr<const std::byte> texels, size_t size)
    : texels_(std::move(texels)),
      size_(size),
      prefetched_(
          std::make_unique<std::atomic<bool>[]>((size + kPrefetchBytes - 1) / kPrefetchBytes)) {}

// Errors are ignored, since a page that was not prefetched is read when it is accessed.
void MappedTexels::prefetch_part(size_t part) const {
  prefetched_[part].store(true, std::memory_order_relaxed);
  const size_t begin = part * kPrefetchBytes;
  ::madvise(const_cast<std::byte*>(data() + begin), std::min(kPrefetchBytes, size_ - begin),
            MADV_WILLNEED);
}

void MappedTexels::release_pages() const {
  for (size_t part = 0; part * kPrefetchBytes < size_; ++part) {
    prefetched_[part].store(false, std::memory_order_relaxed);
  }
  ::madvise(const_cast<std::byte*>(data()), size_, MADV_DONTNEED);
}

}  // namespace emberline
