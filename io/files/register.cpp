#include "io/files/register.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "io/files/atomic_file.h"
#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

std::string key_of(const FileIdentity& file) {
  return std::to_string(file.device) + ":" + std::to_string(file.inode);
}

[[noreturn]] void throw_conflict(const std::string& option, const std::string& path,
                                 const std::string& what) {
  throw UsageError("{} {}: {}; name another file", option, path, what);
}

}  // namespace

std::string FileRegister::ResolvedPath::key() const {
  return file ? key_of(*file) : folder_key() + "/" + lower_case(path.filename().string());
}

std::string FileRegister::ResolvedPath::folder_key() const {
  return folder ? key_of(*folder) : path.parent_path().string();
}

std::string FileRegister::ResolvedPath::key_as_folder() const {
  return file ? key_of(*file) : path.string();
}

bool FileRegister::Output::is_ancestor_of(const ResolvedPath& other) const {
  for (fs::path above = other.path; above.has_relative_path();) {
    above = above.parent_path();
    if (place.file && file_identity(above) == place.file) return true;
  }
  return false;
}

void FileRegister::throw_duplicate(const Output& output, const Output& other) {
  throw_conflict(output.option, output.given_path,
                 "it is also written by " + other.option + " " + other.given_path);
}

FileRegister::ResolvedPath FileRegister::resolve_path(const fs::path& path) {
  std::error_code error;
  ResolvedPath place;
  place.path = follow_links(fs::absolute(path, error));
  const fs::path name = place.path.filename();
  if (name.empty() || name == "." || name == "..") {
    place.path = fs::weakly_canonical(place.path, error);
    if (!place.path.has_filename()) place.path = place.path.parent_path();
  }
  const fs::path above = place.path.parent_path();
  const auto [known, is_new] = known_folders_.try_emplace(above.string());
  Folder& folder = known->second;
  if (is_new) {
    folder.path = fs::weakly_canonical(above, error);
    if (error) folder.path = above;
    folder.identity = file_identity(folder.path);
  }
  place.path = folder.path / place.path.filename();
  place.file = file_identity(place.path);
  place.folder = folder.identity;
  return place;
}

void FileRegister::check_inputs(
    const Output& output, const std::function<bool(const ResolvedPath& place)>& covers) const {
  for (const Input& input : inputs_) {
    if (covers(input.place)) throw_conflict(output.option, output.given_path, input.what);
  }
}

const FileRegister::Output* FileRegister::find_writer(const ResolvedPath& place) const {
  if (const auto at = files_.find(place.key()); at != files_.end()) return at->second;
  const auto at = folders_.find(place.folder_key());
  if (at != folders_.end() && at->second->names_file(place)) return at->second;
  const auto tree = std::ranges::find_if(trees_, [&](auto* t) { return t->is_ancestor_of(place); });
  return tree != trees_.end() ? *tree : nullptr;
}

void FileRegister::add(Input input) {
  const Output* const output = find_writer(input.place);
  if (output) throw_conflict(output->option, output->given_path, input.what);
  input_of_.try_emplace(input.place.key(), inputs_.size());
  inputs_.push_back(std::move(input));
}

void FileRegister::read(const fs::path& path, const std::string& what) {
  add(Input{resolve_path(path), what});
}

void FileRegister::read(const std::vector<NamedFile>& files, const std::string& what) {
  for (const NamedFile& file : files) {
    Input input{resolve_path(file.name), what + " " + file.name};
    input.place.file = file.identity;
    add(std::move(input));
  }
}

void FileRegister::write(const std::string& option, const fs::path& path) {
  if (is_pipe_or_device(path)) return;
  const Output output{option, path.string(), resolve_path(path), {}};
  const std::string key = output.place.key();
  const auto input = input_of_.find(key);
  if (input != input_of_.end())
    throw_conflict(option, output.given_path, inputs_[input->second].what);
  if (const Output* const other = find_writer(output.place)) throw_duplicate(output, *other);
  const Output* const added = &outputs_.emplace_back(output);
  files_[key] = added;
  files_in_[output.place.folder_key()].push_back(added);
}

void FileRegister::write_in(const std::string& option, const fs::path& folder,
                            std::function<bool(const std::string& name)> names) {
  const Output output{option, folder.string(), resolve_path(folder), std::move(names)};
  const std::string key = output.place.key_as_folder();
  check_inputs(output, [&](const ResolvedPath& place) {
    return place.folder_key() == key && output.names_file(place);
  });
  for (const Output* const other : files_in_[key]) {
    if (output.names_file(other->place)) throw_duplicate(output, *other);
  }
  if (const auto at = folders_.find(key); at != folders_.end())
    throw_duplicate(output, *at->second);
  folders_[key] = &outputs_.emplace_back(output);
}

void FileRegister::write_below(const std::string& option, const fs::path& folder) {
  const Output output{option, folder.string(), resolve_path(folder), {}};
  check_inputs(output, [&](const ResolvedPath& place) { return output.is_ancestor_of(place); });
  for (const Output& other : outputs_) {
    if (output.is_ancestor_of(other.place)) throw_duplicate(output, other);
  }
  trees_.push_back(&outputs_.emplace_back(output));
}

}  // namespace emberline
