// The one door in: every file that is read is opened here, and by nobody else
// (tests/invariance/one_door.py).
//
// Only regular files are read: a pipe or a device would wait for ever, or never end. Whatever is
// wrong is one InputError at `place`, which names the file or the JSON pointer that asked for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/files/descriptor.h"
#include "renderer/core/file_identity.h"
#include "renderer/core/load_progress.h"

namespace emberline {

// A regular file, open for reading. Reading is thread-safe.
class InputFile {
 public:
  // Throws InputError for a file that is missing, not regular or not readable.
  explicit InputFile(const std::filesystem::path& path) : InputFile(path, path.string()) {}
  InputFile(const std::filesystem::path& path, const std::string& place);
  // Nothing where there is no file of that name; throws for all else.
  static std::optional<InputFile> open_if_there(const std::filesystem::path& path);

  uint64_t size() const { return state_.size; }  // in bytes, when it was opened
  const std::string& place() const { return place_; }
  // It as it was when it was opened, asked for as `name`.
  NamedFile named(const std::string& name) const { return {name, identity_, name_, state_}; }

  // The `count` bytes from `offset` on, which lie inside the file. Throws InputError, also where
  // the file has become shorter; Cancelled, some megabytes after `progress` says so.
  void read(uint64_t offset, uint64_t count, void* bytes,
            const LoadProgress& progress = LoadProgress::unwatched()) const;
  // The same, without an exception: how many bytes there were, at most `count`; -1 for an error of
  // the disk. May begin behind the end.
  int64_t try_read(uint64_t offset, uint64_t count, void* bytes) const noexcept;
  // All of it.
  std::vector<uint8_t> read_all(const LoadProgress& progress = LoadProgress::unwatched()) const;
  std::string read_text() const;

 private:
  std::string about() const;  // ": name", where the place does not name the file

  Descriptor descriptor_;
  std::string name_, place_;
  FileIdentity identity_;
  FileState state_;
};

// The identity of what stands under a name, of whatever kind; nothing if nothing does.
std::optional<FileIdentity> file_identity(const std::filesystem::path& path);
// The same with its state, as it is now.
std::optional<NamedFile> file_now(const std::filesystem::path& path);

// A text that the kernel makes up when it is asked ("/proc/self/status"), which has no size; empty
// if there is none. The first 64 KiB.
std::string read_kernel_text(const char* path);

// A field of /proc/self/statm, proc_pid_statm(5), in bytes; 0 if there is none.
enum class StatmField : int { kResident = 1, kShared = 2 };
uint64_t statm_bytes(StatmField field);

}  // namespace emberline
