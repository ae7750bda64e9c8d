#include "renderer/statistics/study/folder.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/files/input_file.h"
#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/output/render_options.h"
#include "renderer/statistics/study/files.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSettings = "settings.json";
constexpr const char* kPace = "pace.json";
constexpr const char* kRuns = "runs";

// Reads one of the study's own files with `read`. Returns nothing if the file is missing or
// damaged. For a damaged file, also logs the error and `consequence`, a text that says what happens
// instead.
template <typename Value>
std::optional<Value> read_own_file(const std::string& path, const char* consequence,
                                   Value (*read)(const JsonReader& root, std::string_view key),
                                   const std::string& key) {
  if (!file_identity(path)) return std::nullopt;
  try {
    const nlohmann::json json = read_json(path);
    return read(JsonReader(json, path), key);
  } catch (const InputError& error) {
    log_info(std::string(error.what()) + "; " + consequence);
    return std::nullopt;
  }
}

StudyPace parse_pace(const JsonReader& root, std::string_view key) {
  if (root["key"].text() != key) root["key"].throw_expected("the key of this study");
  StudyPace pace;
  pace.reference_spp = uint32_t(root["reference_spp"].whole_number(0, kMaxSamples));
  const JsonReader paces = root["samples_per_s"];
  for (const std::string& id : paces.members()) {
    pace.samples_per_s[id] = paces[id].number(0, std::numeric_limits<float>::max());
  }
  return pace;
}

}  // namespace

OwnedFolderKind study_folder_kind() {
  return {"-o", "emberline-study.json", {kRuns, "pictures", "reference"}, true};
}

StudyFolder::StudyFolder(const std::string& path) : folder_(path, study_folder_kind()) {}

std::string StudyFolder::run_name(const std::string& id, uint32_t seed) {
  return fmt::format("{}/{}_{}.json", kRuns, id, seed);
}

void StudyFolder::begin(const std::string& key, std::vector<std::string> files, bool restart) {
  key_ = key;
  const std::string settings = path(kSettings);
  bool known = false;
  if (!restart && file_identity(settings)) {
    try {
      const nlohmann::json json = read_json(settings);
      known = JsonReader(json, settings)["key"].text() == key;
    } catch (const InputError& error) {
      throw EmberlineError(error.exit_code(),
                           std::string(error.what()) + "; use `restart` to start the study over");
    }
    if (!known) {
      throw UsageError(
          "-o " + folder_.path() +
          ": it contains a study with another frame, other budgets or other settings; name "
          "another folder, or use `restart` to replace it");
    }
  }
  files.insert(files.end(), {kSettings, kPace});
  folder_.check(files);
  if (restart) {
    const std::set<std::string> ours = folder_.files();
    for (const std::string& name : ours) {
      if (name == kPace || name.starts_with(std::string(kRuns) + "/")) folder_.remove(name);
    }
  }
  folder_.claim(files);
  if (!known) write_file_atomically(settings, Json{{"key", key}}.dump() + "\n");
}

std::optional<StudyPace> StudyFolder::read_pace() const {
  return read_own_file(path(kPace), "the sampling speed is measured again", parse_pace, key_);
}

void StudyFolder::write_pace(const StudyPace& pace) const {
  Json json = {{"key", key_}, {"reference_spp", pace.reference_spp}};
  json["samples_per_s"] = Json::object();
  for (const auto& [id, value] : pace.samples_per_s) json["samples_per_s"][id] = value;
  write_file_atomically(path(kPace), json.dump(1) + "\n");
}

std::optional<StudyRun> StudyFolder::read_run(const std::string& id, uint32_t seed) const {
  return read_own_file(path(run_name(id, seed)), "the run is repeated", parse_run, key_);
}

void StudyFolder::write_run(const std::string& id, const StudyRun& run) const {
  write_file_atomically(path(run_name(id, run.seed)), run_json(run, key_));
}

}  // namespace emberline
