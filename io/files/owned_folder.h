// An output folder with a marker file that lists the files that the command wrote there.
//
// Files that the marker does not list are neither overwritten nor removed. Since the folder may
// come from someone else, a listed name is used only if it names a regular file in the folder or in
// one of the command's subfolders.
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "io/files/atomic_file.h"

namespace emberline {

struct OwnedFolderKind {
  std::string option;                        // for messages, such as "-o"
  std::string marker;                        // name of the marker file
  std::vector<std::string> subfolders = {};  // may also hold the command's files
  // If true, missing parent folders are created, and an existing folder must be empty or have a
  // marker. If false, the folder may hold other files too.
  bool exclusive = false;
};

class OwnedFolder {
 public:
  // Creates the folder and locks it. Throws UsageError if another run is filling the folder, or if
  // files that the command did not write are in the way. Throws RenderError if the folder cannot be
  // created or written to, and InputError if its marker is damaged.
  OwnedFolder(const std::string& path, OwnedFolderKind kind);
  ~OwnedFolder();  // removes the folders that the constructor created and that are still empty

  const std::string& path() const { return path_; }
  std::string path(const std::string& name) const;
  std::vector<std::string> entries() const;  // all names in the folder
  // Names of the files that the marker listed and that existed, and the names claimed since.
  const std::set<std::string>& files() const { return files_; }

  // Throws UsageError if one of these names belongs to a file that the command did not write.
  void check(std::span<const std::string> names) const;
  // Call before writing. Does check() and adds the names to the marker. Also throws RenderError.
  void claim(std::span<const std::string> names);
  // Removes the file if it is in files().
  void remove(const std::string& name);

 private:
  bool is_permitted_name(const std::string& name) const;
  void check_subfolders() const;
  void check_empty() const;
  void read_marker();
  void lock();
  void make_folder(const std::string& folder, bool with_parents);
  void remove_empty_folders();

  std::string path_;
  OwnedFolderKind kind_;
  std::set<std::string> files_;
  std::vector<std::string> created_folders_;  // folders, in order of creation
  FolderLock lock_;
};

}  // namespace emberline
