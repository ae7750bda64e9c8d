#include "io/files/owned_folder.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

constexpr int kMarkerVersion = 1;
constexpr const char* kVersionMember = "emberline_folder";

// Returns the type of the entry itself; links are not followed.
fs::file_type type_of(const std::string& path) {
  std::error_code unknown;
  return fs::symlink_status(path, unknown).type();
}

bool is_folder(const std::string& path) {
  std::error_code unknown;
  return fs::is_directory(path, unknown);
}

}  // namespace

OwnedFolder::OwnedFolder(const std::string& path, OwnedFolderKind kind)
    : path_(path), kind_(std::move(kind)) {
  const bool existed = is_folder(path_);
  if (existed) {
    lock();  // before reading the marker, which another run may be extending
    check_subfolders();
    const fs::file_type marker = type_of(this->path(kind_.marker));
    if (marker == fs::file_type::regular) {
      read_marker();
    } else if (marker != fs::file_type::not_found) {
      throw UsageError("{} {}: it is not a readable regular file; name another folder",
                       kind_.option, this->path(kind_.marker));
    } else if (kind_.exclusive) {
      check_empty();
    }
  }
  try {
    make_folder(path_, kind_.exclusive);
    if (!existed) lock();
    check_writable(this->path(kind_.marker));
  } catch (...) {
    remove_empty_folders();
    throw;
  }
}

void OwnedFolder::lock() {
  if (lock_.try_lock(path_)) return;
  created_folders_.clear();  // the other run uses these folders now
  throw UsageError(
      kind_.option + " " + path_ +
      ": another run is writing to this folder; wait until it ends, or name another folder");
}

OwnedFolder::~OwnedFolder() { remove_empty_folders(); }

void OwnedFolder::remove_empty_folders() {
  std::error_code ignored;  // folders that are not empty stay
  for (auto folder = created_folders_.rbegin(); folder != created_folders_.rend(); ++folder) {
    fs::remove(*folder, ignored);
  }
}

std::string OwnedFolder::path(const std::string& name) const {
  return (fs::path(path_) / name).string();
}

void OwnedFolder::make_folder(const std::string& folder, bool with_parents) {
  const std::string parent = fs::path(folder).parent_path().string();
  if (with_parents && !parent.empty() && parent != folder && !is_folder(parent)) {
    make_folder(parent, true);
  }
  std::error_code error;
  if (fs::create_directory(folder, error)) created_folders_.push_back(folder);
  if (!is_folder(folder)) {
    throw RenderError("{} {}: cannot create the folder: {}", kind_.option, folder,
                      error ? error.message() : "a file with this name exists");
  }
}

void OwnedFolder::check_subfolders() const {
  for (const std::string& name : kind_.subfolders) {
    const fs::file_type type = type_of(path(name));
    if (type == fs::file_type::directory || type == fs::file_type::not_found) continue;
    throw UsageError("{} {}: it is {} but must be a folder; name another folder", kind_.option,
                     path(name), type == fs::file_type::symlink ? "a symbolic link" : "a file");
  }
}

std::vector<std::string> OwnedFolder::entries() const {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(path_, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  if (error) throw RenderError("{} {}: {}", kind_.option, path_, error.message());
  return names;
}

void OwnedFolder::check_empty() const {
  for (const std::string& name : entries()) {
    if (name.starts_with(kind_.marker + ".part")) continue;  // left by a killed run
    throw UsageError(kind_.option + " " + path_ + ": it is not empty (it contains " + name +
                     ") and has no " + kind_.marker +
                     " that lists this command's files; name a new folder");
  }
}

// Accepts "name" and "subfolder/name", but no name that leads out of the folder.
bool OwnedFolder::is_permitted_name(const std::string& name) const {
  const size_t slash = name.find('/');
  const std::string file = slash == std::string::npos ? name : name.substr(slash + 1);
  const bool in_folder =
      slash == std::string::npos ||
      std::ranges::find(kind_.subfolders, name.substr(0, slash)) != kind_.subfolders.end();
  return in_folder && !file.empty() && file != "." && file != ".." && name != kind_.marker &&
         file.find_first_of(std::string_view("/\0", 2)) == std::string::npos;
}

void OwnedFolder::read_marker() {
  const std::string file = path(kind_.marker);
  const nlohmann::json json = read_json(file);
  const JsonReader root(json, file);
  root[kVersionMember].whole_number(kMarkerVersion, kMarkerVersion);
  const JsonReader names = root["files"];
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string name = names[i].text();
    if (is_permitted_name(name) && type_of(path(name)) == fs::file_type::regular)
      files_.insert(name);
  }
}

void OwnedFolder::check(std::span<const std::string> names) const {
  for (const std::string& name : names) {
    const fs::file_type type = type_of(path(name));
    if (type == fs::file_type::not_found) continue;
    if (type == fs::file_type::regular && files_.contains(name)) continue;
    throw UsageError(
        kind_.option + " " + path(name) +
        ": this file was not written by this command and would be overwritten; move it away or "
        "name another folder");
  }
}

void OwnedFolder::claim(std::span<const std::string> names) {
  check(names);
  const size_t before = files_.size();
  files_.insert(names.begin(), names.end());
  if (files_.size() == before) return;
  const nlohmann::json marker = {{kVersionMember, kMarkerVersion}, {"files", files_}};
  constexpr auto kReplace = nlohmann::json::error_handler_t::replace;
  write_file_atomically(path(kind_.marker), marker.dump(1, ' ', false, kReplace) + "\n");
  for (const std::string& name : kind_.subfolders) make_folder(path(name), false);
}

void OwnedFolder::remove(const std::string& name) {
  if (!files_.contains(name) || type_of(path(name)) != fs::file_type::regular) return;
  std::error_code ignored;
  fs::remove(path(name), ignored);
  files_.erase(name);
}

}  // namespace emberline
