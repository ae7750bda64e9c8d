// Registers all files that a run reads and writes. This ensures that no output overwrites an input
// or another output, however their names are spelt.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "renderer/core/file_identity.h"

namespace emberline {

// Existing files are compared by device and inode, so links and ".." make no difference. New files
// are compared by folder and name. Case is ignored, since some file systems ignore it. Pipes and
// devices (/dev/stdout) are not replaced and not registered.
//
// Inputs and outputs may be registered in any order. For a conflicting pair, the second call throws
// a UsageError that names the output and says what the other file is (`what`: "it is the scene").
class FileRegister {
 public:
  FileRegister() = default;
  FileRegister(const FileRegister&) = delete;
  FileRegister& operator=(const FileRegister&) = delete;

  void read(const std::filesystem::path& path, const std::string& what);
  void read(const std::vector<NamedFile>& files, const std::string& what);
  // `option` is the option that names the output, such as "-o".
  void write(const std::string& option, const std::filesystem::path& path);
  // Reserves all files in `folder` whose names `names` accepts. Allowed only once per folder.
  void write_in(const std::string& option, const std::filesystem::path& folder,
                std::function<bool(const std::string& name)> names);
  // Reserves every file in `folder` and in the folders below it.
  void write_below(const std::string& option, const std::filesystem::path& folder);

 private:
  struct ResolvedPath {
    std::filesystem::path path;                // canonical, as far as it exists
    std::optional<FileIdentity> file, folder;  // if they exist

    std::string key() const;            // the same for all names of a file
    std::string folder_key() const;     // key of the folder that holds this file
    std::string key_as_folder() const;  // if this is a folder: folder_key() of its files
  };
  struct Input {
    ResolvedPath place;
    std::string what;
  };
  struct Output {
    std::string option, given_path;
    ResolvedPath place;
    std::function<bool(const std::string& name)> names;  // which files of the folder are reserved

    bool names_file(const ResolvedPath& other) const {
      return names(other.path.filename().string());
    }
    bool is_ancestor_of(const ResolvedPath& other) const;
  };
  // The cached result of resolving a folder's name. The cache helps because an animation writes
  // thousands of files into one folder.
  struct Folder {
    std::filesystem::path path;
    std::optional<FileIdentity> identity;
  };

  [[noreturn]] static void throw_duplicate(const Output& output, const Output& other);
  ResolvedPath resolve_path(const std::filesystem::path& path);
  void add(Input input);
  // Returns the output that writes this file, or null.
  const Output* find_writer(const ResolvedPath& place) const;
  // Throws if `covers` returns true for an input.
  void check_inputs(const Output& output,
                    const std::function<bool(const ResolvedPath& place)>& covers) const;

  std::unordered_map<std::string, Folder> known_folders_;
  std::vector<Input> inputs_;
  std::unordered_map<std::string, size_t> input_of_;
  std::deque<Output> outputs_;
  // The keys are key() in files_, folder_key() in files_in_, and key_as_folder() in folders_.
  std::unordered_map<std::string, const Output*> files_, folders_;
  std::unordered_map<std::string, std::vector<const Output*>> files_in_;
  std::vector<const Output*> trees_;  // from write_below()
};

}  // namespace emberline
