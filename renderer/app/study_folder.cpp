#include "renderer/app/study_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "io/atomic_file.h"
#include "renderer/app/study_files.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kSettings = "settings.json";
constexpr const char* kPace = "pace.json";
constexpr const char* kRuns = "runs";

std::optional<std::string> read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

// Null for a file that is not there or no JSON object.
Json read_object(const std::string& path) {
  const std::optional<std::string> text = read_text(path);
  Json json = text ? Json::parse(*text, nullptr, false) : Json();
  return json.is_object() ? json : Json();
}

}  // namespace

StudyFolder::StudyFolder(const std::string& path) : path_(path) {
  for (const char* name : {"", kRuns, "pictures", "reference"}) {
    const std::string folder = (fs::path(path_) / name).string();
    std::error_code error;
    if (fs::create_directories(folder, error)) made_.push_back(folder);
    if (error || !fs::is_directory(folder)) {
      remove_empty();
      throw RenderError("-o " + folder + ": cannot make that folder: " +
                        (error ? error.message() : "there is a file of that name"));
    }
    try {
      check_writable((fs::path(folder) / "study.csv").string());
    } catch (...) {
      remove_empty();
      throw;
    }
  }
}

StudyFolder::~StudyFolder() { remove_empty(); }

void StudyFolder::remove_empty() {
  std::error_code ignored;  // what is not empty stays
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) {
    fs::remove(*folder, ignored);
  }
}

std::string StudyFolder::path(const std::string& name) const {
  return (fs::path(path_) / name).string();
}

void StudyFolder::begin(const std::string& key, bool restart) {
  key_ = key;
  const Json settings = read_object(path(kSettings));
  if (!settings.is_null() && settings.value("key", "") == key && !restart) return;
  if (settings.is_null() && !restart) {
    write_file_atomically(path(kSettings), Json{{"key", key}}.dump() + "\n");
    return;
  }
  if (!restart) {
    throw UsageError("-o " + path_ +
                     ": holds a study of another frame, budgets or settings; name another folder, "
                     "or give --restart to replace it");
  }
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(path(kRuns), ignored)) {
    fs::remove(entry.path(), ignored);
  }
  fs::remove(path(kPace), ignored);
  write_file_atomically(path(kSettings), Json{{"key", key}}.dump() + "\n");
}

std::optional<StudyPace> StudyFolder::read_pace() const {
  try {
    const Json json = read_object(path(kPace));
    if (json.is_null() || json.at("key") != key_) return std::nullopt;
    StudyPace pace;
    pace.reference_spp = json.at("reference_spp");
    for (const auto& [id, value] : json.at("samples_per_s").items()) {
      pace.samples_per_s[id] = value;
    }
    return pace;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

void StudyFolder::write_pace(const StudyPace& pace) const {
  Json json = {{"key", key_}, {"reference_spp", pace.reference_spp}};
  json["samples_per_s"] = Json::object();
  for (const auto& [id, value] : pace.samples_per_s) json["samples_per_s"][id] = value;
  write_file_atomically(path(kPace), json.dump(1) + "\n");
}

std::string StudyFolder::run_path(const std::string& id, uint32_t seed) const {
  return path(fmt::format("{}/{}_{}.json", kRuns, id, seed));
}

std::optional<StudyRun> StudyFolder::read_run(const std::string& id, uint32_t seed) const {
  const std::optional<std::string> text = read_text(run_path(id, seed));
  return text ? parse_run(*text, key_) : std::nullopt;
}

void StudyFolder::write_run(const std::string& id, const StudyRun& run) const {
  write_file_atomically(run_path(id, run.seed), run_json(run, key_));
}

}  // namespace emberline
