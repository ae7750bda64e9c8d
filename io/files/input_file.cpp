#include "io/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <sstream>
#include <system_error>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

// Files are read in parts of this size. Reading a part takes a few milliseconds, and a load can be
// cancelled between two parts.
constexpr uint64_t kPartBytes = uint64_t(8) << 20;

std::string system_message(int error) { return std::generic_category().message(error); }

// With O_NONBLOCK, opening a pipe does not wait for its other end. For regular files, the flag has
// no effect.
Descriptor open_to_read(const std::filesystem::path& path) {
  int descriptor = -1;
  do {
    descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  } while (descriptor < 0 && errno == EINTR);
  return Descriptor(descriptor);
}

FileIdentity identity_of(const struct stat& status) {
  return {uint64_t(status.st_dev), uint64_t(status.st_ino)};
}

FileState state_of(const struct stat& status) {
  const auto& modified = status.st_mtim;
  return {uint64_t(status.st_size), int64_t(modified.tv_sec) * 1'000'000'000 + modified.tv_nsec};
}

const char* describe_kind(mode_t mode) {
  if (S_ISDIR(mode)) return "is a directory, not a file";
  if (S_ISFIFO(mode)) return "is a pipe, not a regular file";
  if (S_ISSOCK(mode)) return "is a socket, not a regular file";
  return "is a device, not a regular file";
}

}  // namespace

InputFile::InputFile(const std::filesystem::path& path, const std::string& place)
    : name_(path.string()), place_(place) {
  // Checks the type before opening, since opening a device may have side effects.
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) {
    const int error = errno;
    throw InputError(place_,
                     error == ENOENT || error == ENOTDIR
                         ? "file not found" + name_suffix()
                         : "cannot access the file" + name_suffix() + ": " + system_message(error));
  }
  if (!S_ISREG(status.st_mode))
    throw InputError(place_, describe_kind(status.st_mode) + name_suffix());
  descriptor_ = open_to_read(path);
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
    throw InputError(place_, "cannot open the file{}: {}", name_suffix(), system_message(errno));
  }
  if (!S_ISREG(status.st_mode))
    throw InputError(place_, describe_kind(status.st_mode) + name_suffix());
  identity_ = identity_of(status);
  state_ = state_of(status);
}

std::optional<InputFile> InputFile::try_open(const std::filesystem::path& path) {
  if (!file_identity(path)) return std::nullopt;
  return InputFile(path);
}

std::string InputFile::name_suffix() const {
  return name_ == place_ ? "" : ": " + shortened(name_);
}

int64_t InputFile::try_read(uint64_t offset, uint64_t count, void* bytes) const noexcept {
  return descriptor_.read_at(bytes, count, offset);
}

void InputFile::read(uint64_t offset, uint64_t count, void* bytes,
                     const LoadProgress& progress) const {
  auto* next = static_cast<uint8_t*>(bytes);
  while (count > 0) {
    progress.check();
    const uint64_t part = std::min(count, kPartBytes);
    const int64_t got = try_read(offset, part, next);
    if (got < 0)
      throw InputError(place_, "cannot read the file{}: {}", name_suffix(), system_message(errno));
    if (uint64_t(got) < part) {
      throw InputError(place_, "the file was truncated while it was being read" + name_suffix());
    }
    next += part;
    offset += part;
    count -= part;
  }
}

std::vector<uint8_t> InputFile::read_all(const LoadProgress& progress) const {
  std::vector<uint8_t> bytes(size());
  read(0, size(), bytes.data(), progress);
  return bytes;
}

std::string InputFile::read_text() const {
  std::string text(size(), '\0');
  read(0, size(), text.data());
  return text;
}

std::optional<FileIdentity> file_identity(const std::filesystem::path& path) {
  const std::optional<NamedFile> file = stat_file(path);
  return file ? std::optional(file->identity) : std::nullopt;
}

std::optional<NamedFile> stat_file(const std::filesystem::path& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return NamedFile{path.string(), identity_of(status), path.string(), state_of(status)};
}

std::string read_kernel_text(const char* path) {
  const Descriptor descriptor = open_to_read(path);
  std::string text(size_t(64) << 10, '\0');
  text.resize(size_t(std::max<int64_t>(0, descriptor.read_at(text.data(), text.size(), 0))));
  return text;
}

uint64_t statm_bytes(StatmField field) {
  std::istringstream text(read_kernel_text("/proc/self/statm"));
  uint64_t pages = 0;
  for (int i = 0; i <= int(field); ++i) text >> pages;
  return text ? pages * uint64_t(::sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace emberline
