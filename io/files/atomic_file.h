// Files that appear whole or not at all: written beside their target, flushed to disk, renamed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "io/files/descriptor.h"

namespace emberline {

// A file under a temporary name in its target's folder ("out.exr.emberline.part-<pid>"), which
// takes the target's place in commit(). Destroyed without commit() it leaves nothing behind, and
// what stood under the target's name before is untouched.
//
// It is locked (flock) while it is in use. One of the same target and user that nobody holds is
// what a killed run has left: whoever writes that target next removes it. Where a file system has
// no locks, such files stay.
//
// A target that is a symbolic link stays one: the file it points to is replaced, or made. The
// permissions of a replaced file are kept. All errors are RenderError, one line that names the
// target.
class AtomicFile {
 public:
  // Throws when the target is a folder, a device or write-protected, or its folder is not writable.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();

  // Thread-safe for disjoint ranges. Throws (disk full, I/O error).
  void write_at(const void* bytes, size_t count, uint64_t offset);

  // As write_at, for callers that cannot be thrown through: 0, or the errno.
  int try_write_at(const void* bytes, size_t count, uint64_t offset) noexcept;

  // Flushes the file, renames it and flushes the folder. Throws; the temporary file is then gone.
  void commit();
  // The same; the lock goes on until the descriptor that is returned is closed. A `fresh` file
  // takes no other's place: throws where there is one.
  Descriptor commit_locked(bool fresh = false);

  const std::string& path() const { return path_; }  // as the caller gave it

 private:
  friend class LockedFile;
  AtomicFile(const std::string& path, std::string target);

  void discard() noexcept;

  std::string path_;          // for messages
  std::string target_;        // path_ with symbolic links resolved
  std::string temporary_;     // empty once renamed or removed
  int unfinished_slot_ = -1;  // see remove_unfinished_files
  Descriptor descriptor_;
};

// Whether something stands there that cannot be replaced, as files are.
bool is_pipe_or_device(const std::filesystem::path& path);

// Where a chain of symbolic links leads, to what is not there yet, too.
std::filesystem::path without_links(std::filesystem::path path);

// Throws as AtomicFile's constructor would for a path that cannot be written to, and leaves nothing
// behind; so that it is known before hours of work and not after them.
void check_writable(const std::string& path);

// Unlinks the temporary files of every AtomicFile alive. For a signal handler that is about to end
// the process: async-signal-safe.
void remove_unfinished_files() noexcept;

// Writes the whole of `bytes` as above. A target that is a pipe or a device cannot be renamed onto
// and is written to directly, as is an open descriptor (/dev/stdout), wherever it leads. Throws
// RenderError.
void write_file_atomically(const std::string& path, std::string_view bytes);

// Tells other runs that a folder is in use, until it is destroyed or the process ends (flock).
class FolderLock {
 public:
  // False where another run has told so. A file system without locks keeps nobody out. Once.
  bool take(const std::string& folder);

 private:
  Descriptor descriptor_;
};

// A file that one run at a time has: appended to, or replaced as a whole. All errors are
// RenderError, one line that names the file. One thread at a time.
class LockedFile {
 public:
  // That is not there yet: made whole, with these bytes.
  LockedFile(const std::string& path, std::string_view bytes);
  // One that is there. What killed runs have left beside it is removed.
  explicit LockedFile(const std::string& path);

  // Cuts off what is behind the first `size` bytes.
  void cut(uint64_t size);
  // Behind all others; where that fails, it is as if nothing had been appended.
  void append(std::string_view bytes);
  void sync();  // to the disk
  // Replaces the file with what `write` makes, which is held from then on. Throws where another
  // file has taken its place.
  void replace(const std::function<void(AtomicFile& file)>& write);
  // Whether it still has its name: it may have been removed or replaced.
  bool is_named() const noexcept;
  // Its name goes, if it is still this file's.
  void remove() noexcept;
  // Takes the place of another file in its folder. Throws where it has lost its own name.
  void rename_to(const std::string& path);

  const std::string& path() const { return path_; }
  uint64_t size() const { return size_; }

 private:
  std::string path_;    // as the caller gave it, for messages
  std::string target_;  // path_ with symbolic links resolved, as they were at the beginning
  Descriptor descriptor_;
  uint64_t size_ = 0;
};

// A file without a name, for what does not fit into memory: it goes with the object, its maps and
// the process, however that ends. All errors are RenderError, one line that says where and what
// for.
class ScratchFile {
 public:
  // In the folder of that file, which has the room: its results go there.
  static ScratchFile beside(const std::string& path);
  // In the folder for temporary files ($TMPDIR, else /tmp); `purpose` is what it cannot do without.
  static ScratchFile temporary(const std::string& purpose);

  // Both thread-safe; writing for disjoint ranges. What was never written reads as zeros.
  void write_at(const void* bytes, size_t count, uint64_t offset);
  void read_at(void* bytes, size_t count, uint64_t offset) const;
  // `count` bytes from `offset` on, a multiple of the page, to be read where they lie: until the
  // pointer's last copy goes, which may outlive the file.
  std::shared_ptr<const std::byte> map(uint64_t offset, uint64_t count) const;

 private:
  ScratchFile(const std::string& folder, std::string failure);
  [[noreturn]] void fail(int error) const;

  std::string failure_;  // a line, but for the reason
  Descriptor descriptor_;
};

// A file that others follow while it grows: empty at first, and what is appended is there at once.
// It waits for no reader of a pipe. All errors are RenderError, one line that names the file.
class GrowingFile {
 public:
  explicit GrowingFile(const std::string& path);

  void append(std::string_view bytes);

 private:
  std::string path_;
  Descriptor descriptor_;
};

}  // namespace emberline
