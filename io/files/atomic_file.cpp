#include "io/files/atomic_file.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

// A slot for the name of a live temporary file. A signal handler can read the slots, since they are
// in fixed memory and need no lock. An atomic exchange gives a slot to one thread at a time, so the
// name in a readable slot is always complete.
struct UnfinishedFile {
  enum State : int { kFree, kTaken, kReadable };
  std::atomic<int> state{kFree};
  char name[PATH_MAX] = {};
};
constexpr size_t kUnfinishedSlots = 64;  // a frame writes fewer files at once
UnfinishedFile g_unfinished[kUnfinishedSlots];
static_assert(std::atomic<int>::is_always_lock_free);

// Stores the name in a free slot. Returns the slot's index, or -1 if no slot is free or the name is
// too long. Only the slot's owner and the signal handler read the name.
int register_unfinished(const std::string& name) noexcept {
  if (name.size() >= PATH_MAX) return -1;
  for (size_t i = 0; i < kUnfinishedSlots; ++i) {
    UnfinishedFile& slot = g_unfinished[i];
    int expected = UnfinishedFile::kFree;
    if (!slot.state.compare_exchange_strong(expected, UnfinishedFile::kTaken)) continue;
    std::copy(name.begin(), name.end(), slot.name);
    slot.name[name.size()] = '\0';
    slot.state = UnfinishedFile::kReadable;
    return int(i);
  }
  return -1;
}

void unregister_unfinished(int slot) noexcept {
  if (slot >= 0) g_unfinished[slot].state = UnfinishedFile::kFree;
}

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
  throw RenderError("cannot write {}: {}{}", path, what,
                    error ? ": " + std::generic_category().message(error) : "");
}

std::optional<std::string> real_path(const std::string& path) {
  std::error_code error;
  const std::filesystem::path resolved = std::filesystem::canonical(path, error);
  return error ? std::nullopt : std::optional(resolved.string());
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

// g_creation_count counts the threads that are creating a temporary file, before the file has a
// slot. Once g_is_terminating is set, no file may be created.
std::atomic<int> g_creation_count{0};
std::atomic<bool> g_is_terminating{false};
static_assert(std::atomic<bool>::is_always_lock_free);

// Guards the creation of a file until the file has its slot. A signal handler that ended the
// process before then would leave the file behind, so it waits for all guards. Signals are blocked
// on this thread, because a handler on this thread would wait for itself.
class CreationGuard {
 public:
  CreationGuard() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &old_signal_mask_);
    ++g_creation_count;
    if (!g_is_terminating) return;
    --g_creation_count;
    while (true) ::pause();
  }
  ~CreationGuard() {
    --g_creation_count;
    pthread_sigmask(SIG_SETMASK, &old_signal_mask_, nullptr);
  }
  CreationGuard(const CreationGuard&) = delete;
  CreationGuard& operator=(const CreationGuard&) = delete;

 private:
  sigset_t old_signal_mask_;
};

// Follows the symbolic links of `path`. If the file does not exist, resolves the links to its
// folder, since these may change while a frame renders.
std::string resolve_links(const std::string& path) {
  if (const std::optional<std::string> file = real_path(path)) return *file;
  const std::filesystem::path end = follow_links(path);
  const std::optional<std::string> folder = real_path(folder_of(end.string()));
  const std::filesystem::path name = end.filename();
  return folder && !name.empty() ? (std::filesystem::path(*folder) / name).string() : path;
}

// Returns the start of the temporary file's name for `target`. The process id and, if needed,
// "-<number>" follow. Stale files are found by name, so no other file may have a name of this form.
std::string temporary_stem(const std::string& target) {
  const std::filesystem::path path(target);
  // Leaves room for the suffix: a target's name may use all of NAME_MAX.
  const std::string name = path.filename().string().substr(0, NAME_MAX - 32);
  return (path.parent_path() / name).string() + ".emberline.part-";
}

// True for a positive number as to_string() writes it.
bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= 10 && text.front() != '0' &&
         std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// True if `path` still names the open file.
bool names_open_file(const std::string& path, int descriptor) {
  struct stat named = {}, opened = {};
  return ::lstat(path.c_str(), &named) == 0 && ::fstat(descriptor, &opened) == 0 &&
         named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
}

// Creates and locks a file beside `target`. The lock tells other runs that the file is in use. The
// name contains the process id, so it differs between concurrent runs. If the name is taken, a
// number is added.
Descriptor create_temporary(const std::string& target, mode_t mode, std::string* temporary) {
  const std::string stem = temporary_stem(target) + std::to_string(getpid());
  for (int attempt = 0; attempt < 1000; ++attempt) {
    *temporary = attempt == 0 ? stem : stem + "-" + std::to_string(attempt);
    Descriptor descriptor(
        ::open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
    if (descriptor < 0 && errno == EEXIST) continue;
    if (descriptor < 0) return descriptor;
    // Another run may have removed the file as stale before this run locked it. If the file system
    // does not support flock, other runs cannot lock the file either, so they do not remove it.
    const bool taken = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    struct stat status = {};
    const bool removed = ::fstat(descriptor, &status) == 0 && status.st_nlink == 0;
    if (!taken && !removed) return descriptor;
  }
  errno = EEXIST;
  return Descriptor();
}

// Removes the file if no run uses it and if a killed run could have left it: it must be a regular
// file of this user with a single link. A file that cannot be locked stays.
void remove_if_stale(const std::string& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (descriptor < 0) return;
  struct stat status = {};
  if (::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 1 &&
      status.st_uid == ::geteuid() && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 &&
      names_open_file(path, descriptor)) {
    ::unlink(path.c_str());
  }
}

// Removes the temporary files that killed runs left for `target`.
void remove_stale_files(const std::string& target) {
  const std::filesystem::path stem(temporary_stem(target));
  const std::string begin = stem.filename().string();
  std::error_code error;
  std::filesystem::directory_iterator entry(folder_of(target), error), end;
  for (; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(begin)) continue;
    const std::string_view rest = std::string_view(name).substr(begin.size());
    const size_t dash = rest.find('-');
    const bool is_temporary = is_number(rest.substr(0, dash)) &&
                              (dash == std::string_view::npos || is_number(rest.substr(dash + 1)));
    std::error_code ignored;
    if (is_temporary && std::filesystem::is_regular_file(entry->symlink_status(ignored))) {
      remove_if_stale(entry->path().string());
    }
  }
}

constexpr int kNoDescriptor = -1, kForeignDescriptor = -2;

// Returns the descriptor's number if `folder` is "/proc/<process>[/task/<thread>]/fd".
int parse_descriptor_path(const std::filesystem::path& folder, const std::string& name) {
  const std::vector<std::string> parts(folder.begin(), folder.end());
  if (parts.size() < 4 || parts[1] != "proc" || parts.back() != "fd") return kNoDescriptor;
  if (!is_number(name) && name != "0") return kNoDescriptor;
  if (parts[2] != std::to_string(::getpid())) return kForeignDescriptor;
  return std::atoi(name.c_str());
}

// Finds the descriptor behind a name such as /dev/stdout. Returns its number in this process, or
// one of the constants above. The file behind a descriptor is never replaced, since other programs
// would continue to write to the old file.
int find_descriptor(const std::string& path) {
  std::error_code error;
  std::filesystem::path at = std::filesystem::absolute(path, error);
  for (int links = 0; links < 40 && !error; ++links) {
    const std::string name = at.filename().string();
    const std::filesystem::path folder = std::filesystem::canonical(at.parent_path(), error);
    if (error) break;
    const int descriptor = parse_descriptor_path(folder, name);
    if (descriptor != kNoDescriptor) return descriptor;
    if (!std::filesystem::is_symlink(std::filesystem::symlink_status(at, error))) break;
    at = at.parent_path() / std::filesystem::read_symlink(at, error);
  }
  return kNoDescriptor;
}

}  // namespace

bool is_pipe_or_device(const std::filesystem::path& path) {
  struct stat status = {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

std::filesystem::path follow_links(std::filesystem::path path) {
  constexpr int kMaxLinks = 40;  // the kernel's limit
  std::error_code error;
  const auto is_link = [&] {
    return std::filesystem::is_symlink(std::filesystem::symlink_status(path, error));
  };
  for (int i = 0; i < kMaxLinks && is_link(); ++i) {
    path = path.parent_path() / std::filesystem::read_symlink(path, error);
  }
  return path;
}

AtomicFile::AtomicFile(const std::string& path) : AtomicFile(path, resolve_links(path)) {}

AtomicFile::AtomicFile(const std::string& path, std::string target)
    : path_(path), target_(std::move(target)) {
  if (path.empty()) throw RenderError("cannot write: the output path is empty");
  if (find_descriptor(path) != kNoDescriptor)
    fail(path_, "it is an open file descriptor; name a file", 0);
  struct stat status = {};
  const bool exists = ::stat(target_.c_str(), &status) == 0;
  if (!exists && (errno == ENAMETOOLONG || errno == ELOOP)) fail(path_, "cannot create it", errno);
  if (exists && S_ISDIR(status.st_mode)) fail(path_, "it is a folder; name a file", 0);
  if (exists && !S_ISREG(status.st_mode)) fail(path_, "it is not a regular file", 0);
  if (exists && ::access(target_.c_str(), W_OK) != 0) fail(path_, "it is write-protected", errno);
  if (std::filesystem::path(target_).filename().empty()) {
    fail(path_, "the path ends in a slash; name a file", 0);
  }

  remove_stale_files(target_);
  int error = 0;
  {
    const CreationGuard creating;
    descriptor_ = create_temporary(target_, 0666, &temporary_);
    error = errno;
    if (descriptor_ >= 0) unfinished_slot_ = register_unfinished(temporary_);
  }
  if (descriptor_ < 0) {
    temporary_.clear();
    const std::string folder = folder_of(target_);
    fail(path_,
         error == ENOENT ? "the folder " + folder + " does not exist"
                         : "cannot create a file in the folder " + folder,
         error == ENOENT ? 0 : error);
  }
  // Errors are ignored, since some file systems do not support permissions.
  if (exists && ::fchmod(descriptor_, status.st_mode & 07777) != 0) errno = 0;
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() noexcept {
  // Unlinks the file while it is still locked, so that no other run can remove it or take its name.
  if (!temporary_.empty()) {
    ::unlink(temporary_.c_str());
    unregister_unfinished(unfinished_slot_);
    temporary_.clear();
  }
  descriptor_ = Descriptor();
}

int AtomicFile::try_write_at(const void* bytes, size_t count, uint64_t offset) noexcept {
  return descriptor_.write_at(bytes, count, offset);
}

void AtomicFile::write_at(const void* bytes, size_t count, uint64_t offset) {
  if (const int error = try_write_at(bytes, count, offset)) fail(path_, "writing failed", error);
}

Descriptor AtomicFile::commit_locked(bool must_be_new) {
  // EINVAL means that the file system cannot flush. No data is lost.
  int error = ::fsync(descriptor_) != 0 && errno != EINVAL ? errno : 0;
  // Some network file systems report a full disk only on close. The duplicate descriptor keeps the
  // lock until the file has its final name.
  Descriptor locked(::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0));
  if (::close(descriptor_.release()) != 0 && error == 0) error = errno;
  bool linked = false;
  if (error == 0 && must_be_new) {
    linked = ::link(temporary_.c_str(), target_.c_str()) == 0;
    // Some network file systems have no hard links. On these, the file is renamed below.
    if (!linked && errno == EEXIST) error = errno;
    if (linked) ::unlink(temporary_.c_str());
  }
  if (error == 0 && !linked && ::rename(temporary_.c_str(), target_.c_str()) != 0) error = errno;
  if (error != 0) {
    discard();
    fail(path_, "the file could not be completed", error);
  }
  unregister_unfinished(unfinished_slot_);
  temporary_.clear();

  // The new name survives a power cut only if the folder is flushed too. The file is complete in
  // any case, so errors are ignored.
  const Descriptor folder(::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder >= 0) ::fsync(folder);
  return locked;
}

void AtomicFile::commit() { commit_locked(); }

void remove_unfinished_files() noexcept {
  constexpr timespec kPause = {0, 100'000};
  g_is_terminating = true;
  for (int i = 0; i < 1000 && g_creation_count > 0; ++i)
    ::nanosleep(&kPause, nullptr);  // at most 0.1 s
  for (UnfinishedFile& slot : g_unfinished) {
    if (slot.state == UnfinishedFile::kReadable) ::unlink(slot.name);
  }
}

void check_writable(const std::string& path) {
  if (const int descriptor = find_descriptor(path); descriptor >= 0) {
    const int flags = ::fcntl(descriptor, F_GETFL);
    if (flags < 0) fail(path, "it is not open", errno);
    if ((flags & O_ACCMODE) == O_RDONLY) fail(path, "it is open for reading only", 0);
  } else if (!is_pipe_or_device(path)) {
    AtomicFile file(path);
  } else if (::access(path.c_str(), W_OK) != 0) {
    fail(path, "cannot open it", errno);
  }
}

void write_file_atomically(const std::string& path, std::string_view bytes) {
  if (is_pipe_or_device(path) || find_descriptor(path) >= 0) return GrowingFile(path).append(bytes);
  AtomicFile file(path);
  file.write_at(bytes.data(), bytes.size(), 0);
  file.commit();
}

bool FolderLock::try_lock(const std::string& folder) {
  descriptor_ = Descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

LockedFile::LockedFile(const std::string& path, std::string_view bytes)
    : path_(path), target_(resolve_links(path)) {
  AtomicFile file(path, target_);
  file.write_at(bytes.data(), bytes.size(), 0);
  descriptor_ = file.commit_locked(true);
  size_ = bytes.size();
}

LockedFile::LockedFile(const std::string& path)
    : path_(path),
      target_(resolve_links(path)),
      descriptor_(::open(target_.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW)) {
  if (descriptor_ < 0) fail(path_, "cannot open it", errno);
  struct stat status = {};
  const bool regular = ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  const bool taken = ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  // Another run may have replaced the file after it was opened.
  const bool named = owns_path();
  if (!regular || taken || !named) {
    fail(path_, regular ? "another run is using it" : "it is not a regular file", 0);
  }
  size_ = uint64_t(status.st_size);
  remove_stale_files(target_);
}

void LockedFile::truncate(uint64_t size) {
  if (::ftruncate(descriptor_, off_t(size)) != 0) fail(path_, "it could not be truncated", errno);
  size_ = size;
}

void LockedFile::append(std::string_view bytes) {
  if (const int error = descriptor_.write_at(bytes.data(), bytes.size(), size_)) {
    if (::ftruncate(descriptor_, off_t(size_)) != 0) {
    }  // if truncating fails, the next append overwrites the remains
    fail(path_, "writing failed", error);
  }
  size_ += bytes.size();
}

void LockedFile::sync() {
  if (::fdatasync(descriptor_) != 0 && errno != EINVAL) fail(path_, "writing failed", errno);
}

void LockedFile::replace(const std::function<void(AtomicFile& file)>& write) {
  AtomicFile file(path_, target_);
  write(file);
  struct stat status = {};
  const bool target_exists = ::lstat(target_.c_str(), &status) == 0;
  if (target_exists && !owns_path()) fail(path_, "another file has replaced it", 0);
  descriptor_ = file.commit_locked(!target_exists);
  if (::fstat(descriptor_, &status) == 0) size_ = uint64_t(status.st_size);
}

bool LockedFile::owns_path() const noexcept { return names_open_file(target_, descriptor_); }

void LockedFile::remove() noexcept {
  if (owns_path()) ::unlink(target_.c_str());
}

void LockedFile::rename_to(const std::string& path) {
  if (!owns_path()) fail(path, path_ + " was removed or replaced", 0);
  std::string target = resolve_links(path);
  if (::rename(target_.c_str(), target.c_str()) != 0) {
    fail(path, "the file could not be completed", errno);
  }
  path_ = path;
  target_ = std::move(target);
}

ScratchFile ScratchFile::beside(const std::string& path) {
  return {folder_of(resolve_links(path)),
          "cannot write " + path + ": cannot use a temporary file in its folder"};
}

ScratchFile ScratchFile::temporary(const std::string& purpose) {
  const char* const chosen = std::getenv("TMPDIR");
  const std::string folder = chosen && *chosen ? chosen : "/tmp";
  return {folder, "cannot " + purpose + " in " + folder + " (set TMPDIR to use another folder)"};
}

ScratchFile::ScratchFile(const std::string& folder, std::string failure)
    : failure_(std::move(failure)),
      descriptor_(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600)) {
  if (descriptor_ >= 0) return;
  // Without support for O_TMPFILE, creates a named file and unlinks it at once.
  if (errno != EOPNOTSUPP && errno != EISDIR) fail(errno);
  std::string name = folder + "/emberline.XXXXXX";
  descriptor_ = Descriptor(::mkostemp(name.data(), O_CLOEXEC));
  if (descriptor_ < 0) fail(errno);
  ::unlink(name.c_str());
}

void ScratchFile::fail(int error) const {
  throw RenderError("{}: {}", failure_, std::generic_category().message(error));
}

void ScratchFile::write_at(const void* bytes, size_t count, uint64_t offset) {
  if (const int error = descriptor_.write_at(bytes, count, offset)) fail(error);
}

void ScratchFile::read_at(void* bytes, size_t count, uint64_t offset) const {
  const int64_t got = descriptor_.read_at(bytes, count, offset);
  if (got < 0) fail(errno);
  std::memset(static_cast<char*>(bytes) + got, 0, count - size_t(got));
}

std::shared_ptr<const std::byte> ScratchFile::map(uint64_t offset, uint64_t count) const {
  void* const at = ::mmap(nullptr, count, PROT_READ, MAP_SHARED, descriptor_, off_t(offset));
  if (at == MAP_FAILED) fail(errno);
  ::madvise(at, count, MADV_RANDOM);
  return {static_cast<const std::byte*>(at),
          [count](const std::byte* p) { ::munmap(const_cast<std::byte*>(p), count); }};
}

GrowingFile::GrowingFile(const std::string& path) : path_(path) {
  const int own = find_descriptor(path);
  if (own == kForeignDescriptor && !is_pipe_or_device(path)) {
    fail(path_, "it is a file descriptor of another process; name a file", 0);
  }
  constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NONBLOCK;
  descriptor_ =
      Descriptor(own >= 0 ? ::fcntl(own, F_DUPFD_CLOEXEC, 0) : ::open(path.c_str(), kFlags, 0666));
  if (descriptor_ < 0 && errno == ENXIO) fail(path_, "it is a pipe without a reader", 0);
  if (descriptor_ < 0) fail(path_, "cannot open it", errno);
}

void GrowingFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EAGAIN)
      fail(path_, "the program that reads the pipe is too slow", 0);
    if (written < 0 && errno != EINTR) fail(path_, "writing failed", errno);
    if (written > 0) bytes.remove_prefix(size_t(written));
  }
}

}  // namespace emberline
