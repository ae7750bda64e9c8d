#include "renderer/session/shared_frames.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr uint64_t kSlots = 2;
constexpr uint64_t kPage = 4096;

[[noreturn]] void throw_failed(const char* what, int error) {
  throw RenderError(std::string("cannot ") + what +
                    " shared memory for pictures: " + std::generic_category().message(error));
}

int create_anonymous_file() {
#if defined(__linux__)
  constexpr unsigned kNotExecutable = 0x8;  // MFD_NOEXEC_SEAL, Linux 6.3
  constexpr unsigned kFlags = MFD_CLOEXEC | MFD_ALLOW_SEALING;
  const int file = ::memfd_create("emberline", kFlags | kNotExecutable);
  return file >= 0 || errno != EINVAL ? file : ::memfd_create("emberline", kFlags);
#else
  errno = ENOSYS;
  return -1;
#endif
}

// Seals the file so that its size can no longer change, because truncating the file would crash its
// readers. From Linux 5.1 on, the sealed file can be written only through the existing mapping.
void seal([[maybe_unused]] int file) {
#if defined(__linux__)
  constexpr int kFutureWrite = 0x10;  // F_SEAL_FUTURE_WRITE, Linux 5.1
  constexpr int kSize = F_SEAL_SHRINK | F_SEAL_GROW;
  if (::fcntl(file, F_ADD_SEALS, kSize | kFutureWrite | F_SEAL_SEAL) != 0 &&
      ::fcntl(file, F_ADD_SEALS, kSize | F_SEAL_SEAL) != 0) {
    throw_failed("seal", errno);
  }
#endif
}

}  // namespace

SharedFrames::~SharedFrames() { close(); }

void SharedFrames::close() {
  if (mapped_) ::munmap(mapped_, kSlots * slot_bytes_);
  if (file_ >= 0) ::close(file_);
  mapped_ = nullptr;
  file_ = -1;
  slot_bytes_ = 0;
  memory_.release();
}

// Allocates all memory at once, so that a shortage is reported here and not by SIGBUS.
void SharedFrames::create(uint64_t slot_bytes) {
  slot_bytes_ = slot_bytes;
  file_ = create_anonymous_file();
  if (file_ < 0) throw_failed("create", errno);
  const auto length = off_t(kSlots * slot_bytes);
  if (::fchmod(file_, S_IRUSR) != 0) throw_failed("protect", errno);
  if (::ftruncate(file_, length) != 0) throw_failed("create", errno);
  if (const int error = ::posix_fallocate(file_, 0, length)) throw_failed("allocate", error);
  void* const mapped =
      ::mmap(nullptr, size_t(length), PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (mapped == MAP_FAILED) throw_failed("map", errno);
  mapped_ = static_cast<std::byte*>(mapped);
  seal(file_);
  ++segment_;
}

SharedFrames::Location SharedFrames::write(std::span<const std::byte> picture,
                                           const std::shared_ptr<MemoryBudget>& budget,
                                           const std::string& place) {
  const uint64_t slot_bytes = (picture.size() + kPage - 1) / kPage * kPage;
  if (slot_bytes != slot_bytes_ || memory_.budget() != budget) {
    close();
    memory_ = MemoryReservation(budget, MemoryPart::kFilm, bytes_of(kSlots, slot_bytes), place);
    try {
      create(slot_bytes);
    } catch (...) {
      close();
      throw;
    }
  }
  const uint64_t offset = written_++ % kSlots * slot_bytes_;
  std::ranges::copy(picture, mapped_ + offset);
  return {fmt::format("/proc/{}/fd/{}", ::getpid(), file_), segment_, kSlots * slot_bytes_, offset};
}

}  // namespace emberline
