// The folder of a study: what is finished is kept there, so that the study can go on.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderer/statistics/study_results.h"

namespace emberline {

// What was measured before the runs, and must stay the same when the study goes on.
struct StudyPace {
  std::map<std::string, double> samples_per_s;  // by the method's id
  uint32_t reference_spp = 0;
};

// Every file appears whole or not at all. Functions that write throw RenderError.
class StudyFolder {
 public:
  // Makes the folder and those in it. Throws RenderError where that cannot be done or nothing can
  // be written there.
  explicit StudyFolder(const std::string& path);
  ~StudyFolder();  // removes what it made and nobody has filled
  StudyFolder(const StudyFolder&) = delete;
  StudyFolder& operator=(const StudyFolder&) = delete;

  // Holds the folder to one study: throws UsageError if it has runs of another key, unless
  // `restart`, which forgets them.
  void begin(const std::string& key, bool restart);

  std::string path(const std::string& name) const;

  std::optional<StudyPace> read_pace() const;
  void write_pace(const StudyPace& pace) const;

  // By the method's id; nothing if that run is not finished, or damaged.
  std::optional<StudyRun> read_run(const std::string& id, uint32_t seed) const;
  void write_run(const std::string& id, const StudyRun& run) const;

 private:
  void remove_empty();
  std::string run_path(const std::string& id, uint32_t seed) const;

  std::string path_;
  std::string key_;
  std::vector<std::string> made_;  // folders, in the order in which they were made
};

}  // namespace emberline
