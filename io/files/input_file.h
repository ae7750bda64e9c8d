// This is the only code that opens files for reading; tests/invariance/one_door.py checks this.
//
// Only regular files are read, because a pipe or a device could block or never end. Every failure
// throws an InputError that names `place`: the file, or the JSON pointer that refers to it.
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
  // Returns nothing if the file does not exist; throws for every other failure.
  static std::optional<InputFile> try_open(const std::filesystem::path& path);

  uint64_t size() const { return state_.size; }  // in bytes, at the time of opening
  const std::string& place() const { return place_; }
  // Returns the file's identity and its state at the time of opening. `name` is the name that the
  // caller asked for.
  NamedFile named_file(const std::string& name) const { return {name, identity_, name_, state_}; }

  // Reads `count` bytes from `offset`. The range must lie inside the file. Throws InputError, also
  // if the file has shrunk since it was opened. After cancellation, reads at most 8 MiB more and
  // then throws Cancelled.
  void read(uint64_t offset, uint64_t count, void* bytes,
            const LoadProgress& progress = LoadProgress::none()) const;
  // Reads up to `count` bytes and returns their number, or -1 on an I/O error. `offset` may be past
  // the end of the file.
  int64_t try_read(uint64_t offset, uint64_t count, void* bytes) const noexcept;
  // Reads the whole file.
  std::vector<uint8_t> read_all(const LoadProgress& progress = LoadProgress::none()) const;
  std::string read_text() const;

 private:
  std::string name_suffix() const;  // ": name", or empty if place_ already is the name

  Descriptor descriptor_;
  std::string name_, place_;
  FileIdentity identity_;
  FileState state_;
};

// Returns the identity of the file or folder at this path, or nothing if the path does not exist.
std::optional<FileIdentity> file_identity(const std::filesystem::path& path);
// Returns the file's identity and its current state.
std::optional<NamedFile> stat_file(const std::filesystem::path& path);

// Reads the first 64 KiB of a file that the kernel generates, such as /proc/self/status. Such files
// report no size. Returns an empty string if the file does not exist.
std::string read_kernel_text(const char* path);

// Returns a field of /proc/self/statm in bytes, or 0 if the field is missing; see
// proc_pid_statm(5).
enum class StatmField : int { kResident = 1, kShared = 2 };
uint64_t statm_bytes(StatmField field);

}  // namespace emberline
