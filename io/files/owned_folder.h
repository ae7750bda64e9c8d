// A folder that a command fills with files, and which of the files in it are the command's own.
//
// A marker in the folder lists them. What it does not list is neither overwritten nor removed, and
// of what it lists only that counts which lies in the folder itself or in one of the command's own
// folders there, and is a regular file: the folder may have come from someone else.
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "io/files/atomic_file.h"

namespace emberline {

struct OwnedFolderKind {
  std::string option;                        // for messages: "-o"
  std::string marker;                        // name of the list
  std::vector<std::string> subfolders = {};  // where its files may lie, beside the folder itself
  // The folder is made with those above it, and if there is one it is empty or has a marker;
  // otherwise it may hold files of others too.
  bool exclusive = false;
};

class OwnedFolder {
 public:
  // Makes the folder, which is its own while it lives. Throws UsageError for one that is not ours
  // to fill or that another run is filling, RenderError for one that cannot be made or written to,
  // and InputError for a marker that is damaged.
  OwnedFolder(const std::string& path, OwnedFolderKind kind);
  ~OwnedFolder();  // removes the folders that it made and nobody has filled

  const std::string& path() const { return path_; }
  std::string path(const std::string& name) const;
  std::vector<std::string> entries() const;  // the names in it, whoever's they are
  // What the marker lists and is there, and what was claimed.
  const std::set<std::string>& files() const { return files_; }

  // Throws UsageError where one of these names belongs to something that is not ours.
  void check(std::span<const std::string> names) const;
  // Checks and lists them, before any of them is written. Throws RenderError too.
  void claim(std::span<const std::string> names);
  // If it is ours.
  void remove(const std::string& name);

 private:
  bool may_be_own(const std::string& name) const;
  void check_subfolders() const;
  void check_empty() const;
  void read_marker();
  void lock();
  void make_folder(const std::string& folder, bool with_parents);
  void remove_empty();

  std::string path_;
  OwnedFolderKind kind_;
  std::set<std::string> files_;
  std::vector<std::string> made_;  // folders, in the order in which they were made
  FolderLock lock_;
};

}  // namespace emberline
