// All files that a run reads and writes, so that no output takes the place of an input, or of
// another output, however their names are spelt.
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

// Files that exist are told apart by device and inode, so that links and ".." deceive nobody; those
// that do not, by their folder's and their name, upper and lower case alike where both are new: on
// some file systems they are. Pipes and devices (/dev/stdout) are not replaced, and not registered.
//
// Inputs and outputs come in any order: whichever comes second throws UsageError, which names the
// output and `what` the other file is ("it is the scene").
class FileRegister {
 public:
  FileRegister() = default;
  FileRegister(const FileRegister&) = delete;
  FileRegister& operator=(const FileRegister&) = delete;

  void read(const std::filesystem::path& path, const std::string& what);
  void read(const std::vector<NamedFile>& files, const std::string& what);
  // `option` wrote it, as in "-o".
  void write(const std::string& option, const std::filesystem::path& path);
  // Any file in that folder whose name is one of these. A folder has one such output.
  void write_in(const std::string& option, const std::filesystem::path& folder,
                std::function<bool(const std::string& name)> names);
  // Any file in that folder, and in those below.
  void write_below(const std::string& option, const std::filesystem::path& folder);

 private:
  struct Place {
    std::filesystem::path path;                // as far as it exists, without links
    std::optional<FileIdentity> file, folder;  // where there are such

    std::string key() const;         // equal for names of one file
    std::string folder_key() const;  // of the folder it is in
    std::string inner_key() const;   // of a folder: folder_key() of what is in it
  };
  struct Input {
    Place place;
    std::string what;
  };
  struct Output {
    std::string option, given;
    Place place;
    std::function<bool(const std::string& name)> names;  // of files in a folder

    bool names_file(const Place& other) const { return names(other.path.filename().string()); }
    bool is_above(const Place& other) const;
  };
  // A folder whose name was looked up once: a range writes thousands of files into it.
  struct Folder {
    std::filesystem::path path;
    std::optional<FileIdentity> identity;
  };

  [[noreturn]] static void refuse_twice(const Output& output, const Output& other);
  Place place_of(const std::filesystem::path& path);
  void add(Input input);
  // The output that writes the file of that place, or null.
  const Output* writer_of(const Place& place) const;
  // Throws where one of the inputs is covered.
  void check_inputs(const Output& output,
                    const std::function<bool(const Place& place)>& covers) const;

  std::unordered_map<std::string, Folder> known_folders_;
  std::vector<Input> inputs_;
  std::unordered_map<std::string, size_t> input_of_;
  std::deque<Output> outputs_;
  // By key, by the folder they are in, folders that are written to by their own key.
  std::unordered_map<std::string, const Output*> files_, folders_;
  std::unordered_map<std::string, std::vector<const Output*>> files_in_;
  std::vector<const Output*> trees_;  // of write_below()
};

}  // namespace emberline
