// Replaces files atomically: writes a temporary file beside the target, flushes it to disk, and
// renames it.
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

// Writes to a temporary file in the target's folder ("out.exr.emberline.part-<pid>"), which
// replaces the target in commit(). An AtomicFile that is destroyed without commit() leaves no file
// behind and does not touch an existing target.
//
// The temporary file is locked (flock) while it is in use. A temporary file without a lock was left
// by a killed run. It is removed when the same user next creates an AtomicFile for the same target.
// On a file system without locks, such files stay.
//
// If the target is a symbolic link, the link stays and the file that it points to is replaced or
// created. A replaced file keeps its permissions. Every error is a RenderError with one line that
// names the target.
class AtomicFile {
 public:
  // Throws if the target is a folder, a device or write-protected, or if its folder is not
  // writable.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();

  // Thread-safe for disjoint ranges. Throws (disk full, I/O error).
  void write_at(const void* bytes, size_t count, uint64_t offset);

  // Like write_at(), but returns 0 or an errno value, for callers that must not throw.
  int try_write_at(const void* bytes, size_t count, uint64_t offset) noexcept;

  // Flushes the file, renames it and flushes the folder. If this throws, the temporary file has
  // already been removed.
  void commit();
  // Like commit(), but the lock is kept until the returned descriptor is closed. With
  // `must_be_new`, throws if the target exists.
  Descriptor commit_locked(bool must_be_new = false);

  const std::string& path() const { return path_; }  // as given by the caller

 private:
  friend class LockedFile;
  AtomicFile(const std::string& path, std::string target);

  void discard() noexcept;

  std::string path_;          // for messages
  std::string target_;        // path_ with symbolic links resolved
  std::string temporary_;     // empty once renamed or removed
  int unfinished_slot_ = -1;  // see remove_unfinished_files()
  Descriptor descriptor_;
};

// Whether the path is a pipe or a device, which cannot be replaced by renaming.
bool is_pipe_or_device(const std::filesystem::path& path);

// Follows a chain of symbolic links. The last name in the chain need not exist.
std::filesystem::path follow_links(std::filesystem::path path);

// Throws if AtomicFile's constructor would throw for this path. Leaves nothing behind. Callers use
// this to fail before hours of rendering and not after them.
void check_writable(const std::string& path);

// Unlinks the temporary file of every live AtomicFile. Async-signal-safe, for a signal handler that
// is about to end the process.
void remove_unfinished_files() noexcept;

// Writes all of `bytes` atomically. Pipes, devices and open descriptors (/dev/stdout) are written
// to directly, since they cannot be replaced. Throws RenderError.
void write_file_atomically(const std::string& path, std::string_view bytes);

// Marks a folder as in use (flock) until this object is destroyed or the process ends.
class FolderLock {
 public:
  // Call once. Returns false if another run holds the lock. On a file system without locks, always
  // returns true.
  bool try_lock(const std::string& folder);

 private:
  Descriptor descriptor_;
};

// A file that is locked against other runs. It can be appended to, or replaced as a whole. Every
// error is a RenderError with one line that names the file. Not thread-safe.
class LockedFile {
 public:
  // Creates a new file atomically with these bytes.
  LockedFile(const std::string& path, std::string_view bytes);
  // Opens an existing file and removes the temporary files that killed runs left for it.
  explicit LockedFile(const std::string& path);

  // Truncates the file to `size` bytes.
  void truncate(uint64_t size);
  // Appends at the end. If this fails, the file is unchanged.
  void append(std::string_view bytes);
  void sync();  // flushes to the disk
  // Replaces the file with one that `write` fills, and locks the new file. Throws if another file
  // now has this file's name.
  void replace(const std::function<void(AtomicFile& file)>& write);
  // Whether the path still names this file, which may have been removed or replaced.
  bool owns_path() const noexcept;
  // Unlinks the file if the path still names this file.
  void remove() noexcept;
  // Renames the file within its folder, and replaces any file that has the new name. Throws if this
  // file has itself been removed or replaced.
  void rename_to(const std::string& path);

  uint64_t size() const { return size_; }

 private:
  std::string path_;    // as given by the caller, for messages
  std::string target_;  // path_ with symbolic links resolved when the file was opened
  Descriptor descriptor_;
  uint64_t size_ = 0;
};

// An unnamed file for data that does not fit into memory. The system deletes it once this object
// and its maps are destroyed, or when the process ends. Every error is a RenderError with one line
// that says where the file was and what it was for.
class ScratchFile {
 public:
  // Creates the file in the folder of `path`, an output file. That folder should have enough room,
  // since it must also hold the results.
  static ScratchFile beside(const std::string& path);
  // Creates the file in $TMPDIR, or else in /tmp. Messages begin with "cannot `purpose`".
  static ScratchFile temporary(const std::string& purpose);

  // Reading and writing are thread-safe, but concurrent writes must not overlap. Unwritten ranges
  // read as zeros.
  void write_at(const void* bytes, size_t count, uint64_t offset);
  void read_at(void* bytes, size_t count, uint64_t offset) const;
  // Maps `count` bytes from `offset` (a multiple of the page size) for reading. The map lives until
  // the last copy of the returned pointer is gone, which may be after the ScratchFile is destroyed.
  std::shared_ptr<const std::byte> map(uint64_t offset, uint64_t count) const;

 private:
  ScratchFile(const std::string& folder, std::string failure);
  [[noreturn]] void fail(int error) const;

  std::string failure_;  // the message without its reason
  Descriptor descriptor_;
};

// A file that other programs read while it grows: it starts empty, and appended bytes are visible
// at once. If the path is a pipe, a program must already be reading from it and must keep up, since
// this class does not wait. Every error is a RenderError with one line that names the file.
class GrowingFile {
 public:
  explicit GrowingFile(const std::string& path);

  void append(std::string_view bytes);

 private:
  std::string path_;
  Descriptor descriptor_;
};

}  // namespace emberline
