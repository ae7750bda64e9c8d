// Which file a name stands for, however it is spelt.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace emberline {

// The same for hard links, symbolic links and every spelling of a path. Holds while the file
// exists.
struct FileIdentity {
  uint64_t device = 0, inode = 0;

  auto operator<=>(const FileIdentity&) const = default;
};

// What a folder says of a file's contents: most changes of these change it.
struct FileState {
  uint64_t size = 0;
  int64_t modified_ns = 0;  // since 1970

  bool operator==(const FileState&) const = default;
};

// A file that was read, and the name under which it was asked for.
struct NamedFile {
  std::string name;
  FileIdentity identity;
  std::string path = {};
  FileState state = {};  // when it was opened
};

}  // namespace emberline
