#include "io/file_register.h"

#include <algorithm>
#include <cctype>
#include <system_error>
#include <utility>

#include "io/atomic_file.h"
#include "io/input_file.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

std::string without_case(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return name;
}

bool is_pipe_or_device(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

[[noreturn]] void refuse(const std::string& option, const std::string& path,
                         const std::string& what) {
  throw UsageError("{} {}: {}; name another file", option, path, what);
}

}  // namespace

FileRegister::Place FileRegister::place_of(const fs::path& path) {
  std::error_code error;
  Place place;
  place.path = fs::weakly_canonical(without_links(fs::absolute(path, error)), error);
  if (error) place.path = path;
  if (!place.path.has_filename()) place.path = place.path.parent_path();
  place.file = file_identity(place.path);
  place.folder = file_identity(place.path.parent_path());
  return place;
}

bool FileRegister::same(const Place& a, const Place& b) {
  if (a.file || b.file) return a.file == b.file;
  const bool one_folder =
      a.folder || b.folder ? a.folder == b.folder : a.path.parent_path() == b.path.parent_path();
  return one_folder &&
         without_case(a.path.filename().string()) == without_case(b.path.filename().string());
}

void FileRegister::add(Input input) {
  for (const Output& output : outputs_) {
    if (output.covers(input.place)) refuse(output.option, output.given, input.what);
  }
  inputs_.push_back(std::move(input));
}

void FileRegister::add(Output output) {
  for (const Input& input : inputs_) {
    if (output.covers(input.place)) refuse(output.option, output.given, input.what);
  }
  for (const Output& other : outputs_) {
    if (output.covers(other.place) || other.covers(output.place)) {
      refuse(output.option, output.given,
             "it is written twice: " + other.option + " " + other.given);
    }
  }
  outputs_.push_back(std::move(output));
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
  Output output{option, path.string(), place_of(path), {}};
  output.covers = [place = output.place](const Place& other) { return same(place, other); };
  add(std::move(output));
}

void FileRegister::write_in(const std::string& option, const fs::path& folder,
                            std::function<bool(const std::string& name)> names) {
  Output output{option, folder.string(), place_of(folder), {}};
  output.covers = [place = output.place, names = std::move(names)](const Place& other) {
    const bool inside =
        place.file ? other.folder == place.file : other.path.parent_path() == place.path;
    return inside && names(other.path.filename().string());
  };
  add(std::move(output));
}

void FileRegister::write_below(const std::string& option, const fs::path& folder) {
  Output output{option, folder.string(), place_of(folder), {}};
  output.covers = [place = output.place](const Place& other) {
    for (fs::path above = other.path; above.has_relative_path();) {
      above = above.parent_path();
      if (place.file && file_identity(above) == place.file) return true;
    }
    return false;
  };
  add(std::move(output));
}

}  // namespace emberline
