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

// A file that was read, and the name under which it was asked for.
struct NamedFile {
  std::string name;
  FileIdentity identity;
};

}  // namespace emberline
