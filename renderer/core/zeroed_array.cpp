#include "renderer/core/zeroed_array.h"

#include <algorithm>
#include <cstring>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "renderer/core/parallel.h"

namespace emberline {

// Arrays of at least this many bytes use huge pages.
constexpr size_t kLarge = size_t(8) << 20;

void advise_huge_pages([[maybe_unused]] void* data, [[maybe_unused]] size_t bytes) {
#if defined(__linux__)
  constexpr uintptr_t kPage = 4096;
  if (bytes < kLarge) return;
  const uintptr_t first = (reinterpret_cast<uintptr_t>(data) + kPage - 1) & ~(kPage - 1);
  const uintptr_t last = (reinterpret_cast<uintptr_t>(data) + bytes) & ~(kPage - 1);
  // This is only advice; if the kernel does not follow it, small pages are used.
  (void)madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

void commit_huge_pages(void* zeroes, size_t bytes) {
  advise_huge_pages(zeroes, bytes);
  if (bytes < kLarge) return;
  constexpr size_t kHugePage = size_t(2) << 20;
  volatile char* const data = static_cast<char*>(zeroes);
  parallel_each(bytes / kHugePage + 1,
                [&](size_t page) { data[std::min(page * kHugePage, bytes - 1)] = 0; });
}

void clear_bytes(void* data, size_t bytes) {
  constexpr size_t kGrain = size_t(1) << 20;
  parallel_ranges(bytes, kGrain, [&](size_t begin, size_t end) {
    std::memset(static_cast<char*>(data) + begin, 0, end - begin);
  });
}

}  // namespace emberline
