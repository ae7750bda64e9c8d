// The folder of a study, which keeps finished work so that the study can be resumed.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/files/owned_folder.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// Measured before the runs. It must stay the same when the study is resumed.
struct StudyPace {
  std::map<std::string, double> samples_per_s;  // key: PlannedMethod::id
  uint32_t reference_spp = 0;
};

OwnedFolderKind study_folder_kind();

// Files are written atomically. Functions that write throw RenderError.
class StudyFolder {
 public:
  // Throws like OwnedFolder's constructor.
  explicit StudyFolder(const std::string& path);

  // Reserves the folder for one study. Throws UsageError if it has runs with another key, unless
  // `restart` is set, which removes them; throws InputError for damaged settings. `files` are all
  // files that the study will write besides its settings and pace; existing ones must belong to a
  // study.
  void begin(const std::string& key, std::vector<std::string> files, bool restart);
  void claim(const std::vector<std::string>& files) { folder_.claim(files); }

  std::string path(const std::string& name) const { return folder_.path(name); }
  static std::string run_name(const std::string& id, uint32_t seed);

  std::optional<StudyPace> read_pace() const;
  void write_pace(const StudyPace& pace) const;

  // Reads a run by the method's id. Empty if the run is not finished, or is damaged, which is
  // logged.
  std::optional<StudyRun> read_run(const std::string& id, uint32_t seed) const;
  void write_run(const std::string& id, const StudyRun& run) const;

 private:
  OwnedFolder folder_;
  std::string key_;
};

}  // namespace emberline
