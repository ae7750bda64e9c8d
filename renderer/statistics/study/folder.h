// The folder of a study: what is finished is kept there, so that the study can go on.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/files/owned_folder.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// What was measured before the runs, and must stay the same when the study goes on.
struct StudyPace {
  std::map<std::string, double> samples_per_s;  // by the method's id
  uint32_t reference_spp = 0;
};

OwnedFolderKind study_folder_kind();

// Every file appears whole or not at all. Functions that write throw RenderError.
class StudyFolder {
 public:
  // Throws as OwnedFolder's constructor does.
  explicit StudyFolder(const std::string& path);

  // Holds the folder to one study: throws UsageError if it has runs of another key, unless
  // `restart`, which removes them, and InputError for settings that are damaged. `files` are all
  // that the study will write beside its settings and pace, none of which may be someone else's.
  void begin(const std::string& key, std::vector<std::string> files, bool restart);
  void claim(const std::vector<std::string>& files) { folder_.claim(files); }

  std::string path(const std::string& name) const { return folder_.path(name); }
  static std::string run_name(const std::string& id, uint32_t seed);

  std::optional<StudyPace> read_pace() const;
  void write_pace(const StudyPace& pace) const;

  // By the method's id; nothing if that run is not finished, or damaged, which is then said.
  std::optional<StudyRun> read_run(const std::string& id, uint32_t seed) const;
  void write_run(const std::string& id, const StudyRun& run) const;

 private:
  OwnedFolder folder_;
  std::string key_;
};

}  // namespace emberline
