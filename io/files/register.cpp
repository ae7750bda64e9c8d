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

[[noreturn]] void refuse(const std::string& option, const std::string& path,
                         const std::string& what) {
  throw UsageError("{} {}: {}; name another file", option, path, what);
}

}  // namespace

std::string FileRegister::Place::key() const {
  return file ? key_of(*file) : folder_key() + "/" + lower_case(path.filename().string());
}

std::string FileRegister::Place::folder_key() const {
  return folder ? key_of(*folder) : path.parent_path().string();
}

std::string FileRegister::Place::inner_key() const { return file ? key_of(*file) : path.string(); }

bool FileRegister::Output::is_above(const Place& other) const {
  for (fs::path above = other.path; above.has_relative_path();) {
    above = above.parent_path();
    if (place.file && file_identity(above) == place.file) return true;
  }
  return false;
}

void FileRegister::refuse_twice(const Output& output, const Output& other) {
  refuse(output.option, output.given, "it is also the file of " + other.option + " " + other.given);
}

FileRegister::Place FileRegister::place_of(const fs::path& path) {
  std::error_code error;
  Place place;
  place.path = without_links(fs::absolute(path, error));
  const fs::path name = place.path.filename();
  if (name.empty() || name == "." || name == "..") {
    place.path = fs::weakly_canonical(place.path, error);
    if (!place.path.has_filename()) place.path = place.path.parent_path();
  }
  const fs::path above = place.path.parent_path();
  const auto [known, fresh] = known_folders_.try_emplace(above.string());
  Folder& folder = known->second;
  if (fresh) {
    folder.path = fs::weakly_canonical(above, error);
    if (error) folder.path = above;
    folder.identity = file_identity(folder.path);
  }
  place.path = folder.path / place.path.filename();
  place.file = file_identity(place.path);
  place.folder = folder.identity;
  return place;
}

void FileRegister::check_inputs(const Output& output,
                                const std::function<bool(const Place& place)>& covers) const {
  for (const Input& input : inputs_) {
    if (covers(input.place)) refuse(output.option, output.given, input.what);
  }
}

const FileRegister::Output* FileRegister::writer_of(const Place& place) const {
  if (const auto at = files_.find(place.key()); at != files_.end()) return at->second;
  const auto at = folders_.find(place.folder_key());
  if (at != folders_.end() && at->second->names_file(place)) return at->second;
  const auto tree = std::ranges::find_if(trees_, [&](auto* t) { return t->is_above(place); });
  return tree != trees_.end() ? *tree : nullptr;
}

void FileRegister::add(Input input) {
  const Output* const output = writer_of(input.place);
  if (output) refuse(output->option, output->given, input.what);
  input_of_.try_emplace(input.place.key(), inputs_.size());
  inputs_.push_back(std::move(input));
}

void FileRegister::read(const fs::path& path, const std::string& what) {
  add(Input{place_of(path), what});
}

void FileRegister::read(const std::vector<NamedFile>& files, const std::string& what) {
  for (const NamedFile& file : files) {
    Input input{place_of(file.name), what + " " + file.name};
    input.place.file = file.identity;
    add(std::move(input));
  }
}

void FileRegister::write(const std::string& option, const fs::path& path) {
  if (is_pipe_or_device(path)) return;
  const Output output{option, path.string(), place_of(path), {}};
  const std::string key = output.place.key();
  const auto input = input_of_.find(key);
  if (input != input_of_.end()) refuse(option, output.given, inputs_[input->second].what);
  if (const Output* const other = writer_of(output.place)) refuse_twice(output, *other);
  const Output* const added = &outputs_.emplace_back(output);
  files_[key] = added;
  files_in_[output.place.folder_key()].push_back(added);
}

void FileRegister::write_in(const std::string& option, const fs::path& folder,
                            std::function<bool(const std::string& name)> names) {
  const Output output{option, folder.string(), place_of(folder), std::move(names)};
  const std::string key = output.place.inner_key();
  check_inputs(output, [&](const Place& place) {
    return place.folder_key() == key && output.names_file(place);
  });
  for (const Output* const other : files_in_[key]) {
    if (output.names_file(other->place)) refuse_twice(output, *other);
  }
  if (const auto at = folders_.find(key); at != folders_.end()) refuse_twice(output, *at->second);
  folders_[key] = &outputs_.emplace_back(output);
}

void FileRegister::write_below(const std::string& option, const fs::path& folder) {
  const Output output{option, folder.string(), place_of(folder), {}};
  check_inputs(output, [&](const Place& place) { return output.is_above(place); });
  for (const Output& other : outputs_) {
    if (output.is_above(other.place)) refuse_twice(output, other);
  }
  trees_.push_back(&outputs_.emplace_back(output));
}

}  // namespace emberline
