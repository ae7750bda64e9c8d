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

// The pace of each method in samples per second, measured before the runs, and the samples per
// pixel of the reference. Both are saved, because a resumed study must use the same values.
struct StudyPace {
  std::map<std::string, double> samples_per_s;  // by PlannedMethod::id
  uint32_t reference_spp = 0;
};

OwnedFolderKind study_folder_kind();

// Files are written atomically. Functions that write throw RenderError.
class StudyFolder {
 public:
  // Throws like OwnedFolder's constructor.
  explicit StudyFolder(const std::string& path);

  // Reserves the folder for one study. If the folder has the runs of a study with another key,
  // throws UsageError or, with `restart`, removes these runs. Throws InputError for damaged
  // settings. `files` are all files that the study will write except its settings and its pace. If
  // one of these files exists, it must belong to a study.
  void begin(const std::string& key, std::vector<std::string> files, bool restart);
  void claim(const std::vector<std::string>& files) { folder_.claim(files); }

  std::string path(const std::string& name) const { return folder_.path(name); }
  static std::string run_name(const std::string& id, uint32_t seed);

  std::optional<StudyPace> read_pace() const;
  void write_pace(const StudyPace& pace) const;

  // Reads the run of the method with this id. Returns nothing if the run is not finished. If its
  // file is damaged, logs this and returns nothing.
  std::optional<StudyRun> read_run(const std::string& id, uint32_t seed) const;
  void write_run(const std::string& id, const StudyRun& run) const;

 private:
  OwnedFolder folder_;
  std::string key_;
};

}  // namespace emberline
