// Identifies a file independently of the spelling of its path.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace emberline {

// The identity is the same for all hard links and symbolic links to a file and for every spelling
// of its path. It is valid only while the file exists.
struct FileIdentity {
  uint64_t device = 0, inode = 0;

  auto operator<=>(const FileIdentity&) const = default;
};

// Metadata of a file that usually change when the contents do.
struct FileState {
  uint64_t size = 0;
  int64_t modified_ns = 0;  // since 1970

  bool operator==(const FileState&) const = default;
};

// An input file and the name under which it was requested.
struct NamedFile {
  std::string name;
  FileIdentity identity;
  std::string path = {};
  FileState state = {};  // when it was opened
};

}  // namespace emberline
