#include "io/files/descriptor.h"

#include <cerrno>

namespace emberline {

int64_t Descriptor::read_at(void* bytes, uint64_t count, uint64_t offset) const noexcept {
  auto* next = static_cast<uint8_t*>(bytes);
  uint64_t done = 0;
  while (done < count) {
    const ssize_t got = ::pread(number_, next + done, size_t(count - done), off_t(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    done += uint64_t(got);
  }
  return int64_t(done);
}

int Descriptor::write_at(const void* bytes, size_t count, uint64_t offset) const noexcept {
  const char* next = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t written = ::pwrite(number_, next, count, off_t(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    next += written;
    count -= size_t(written);
    offset += uint64_t(written);
  }
  return 0;
}

}  // namespace emberline
