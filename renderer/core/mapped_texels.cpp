#include "renderer/core/mapped_texels.h"

#include <sys/mman.h>

namespace emberline {

MappedTexels::MappedTexels(std::shared_ptr<const std::byte> texels, size_t size)
    : texels_(std::move(texels)),
      size_(size),
      asked_(std::make_unique<std::atomic<bool>[]>((size + kPart - 1) / kPart)) {}

// Best effort: a page that is not prefetched is read on access.
void MappedTexels::ask_for_part(size_t part) const {
  asked_[part].store(true, std::memory_order_relaxed);
  const size_t begin = part * kPart;
  ::madvise(const_cast<std::byte*>(data() + begin), std::min(kPart, size_ - begin), MADV_WILLNEED);
}

void MappedTexels::let_go() const {
  for (size_t part = 0; part * kPart < size_; ++part) {
    asked_[part].store(false, std::memory_order_relaxed);
  }
  ::madvise(const_cast<std::byte*>(data()), size_, MADV_DONTNEED);
}

}  // namespace emberline
