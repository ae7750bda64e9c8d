// All files that a run reads and writes, so that no output takes the place of an input, or of
// another output, however their names are spelt.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/file_identity.h"

namespace emberline {

// Files that exist are told apart by device and inode, so that links and ".." deceive nobody; those
// that do not, by their folder's and their name, upper and lower case alike where both are new: on
// some file systems they are. Pipes and devices (/dev/stdout) are not replaced, and not registered.
//
// Inputs and outputs come in any order: whichever comes second throws UsageError, which names the
// output and `what` the other file is ("it is the scene").
class FileRegister {
 public:
  void read(const std::filesystem::path& path, const std::string& what);
  void read(const std::vector<NamedFile>& files, const std::string& what);
  // `option` wrote it, as in "-o".
  void write(const std::string& option, const std::filesystem::path& path);
  // Any file in that folder whose name is one of these.
  void write_in(const std::string& option, const std::filesystem::path& folder,
                std::function<bool(const std::string& name)> names);
  // Any file in that folder, and in those below.
  void write_below(const std::string& option, const std::filesystem::path& folder);

 private:
  struct Place {
    std::filesystem::path path;                // as far as it exists, without links
    std::optional<FileIdentity> file, folder;  // where there are such
  };
  struct Input {
    Place place;
    std::string what;
  };
  struct Output {
    std::string option, given;
    Place place;
    std::function<bool(const Place& other)> covers;
  };

  static Place place_of(const std::filesystem::path& path);
  static bool same(const Place& a, const Place& b);
  void add(Input input);
  void add(Output output);

  std::vector<Input> inputs_;
  std::vector<Output> outputs_;
};

}  // namespace emberline
