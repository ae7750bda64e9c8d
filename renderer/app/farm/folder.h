// OUTPUT.farm, the folder in which `emberline farm` keeps the files of a frame that is rendered in
// parts:
//
//   settings.json   the frame's settings, for `render --settings`
//   part.sh         renders a part; merge.sh merges the parts
//   plan.sh         for an adaptive frame: makes frame.plan, which the parts need
//   job.json        the submitted jobs: FarmRecord
//   progress/       part-K.json and plan.json, as written by --progress-file
//   logs/           part-K.log, plan.log, merge.log
//   merge.json      the merge's report; exists once the merge is done
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/farm/slurm.h"

namespace emberline {

// Replaces every run of four or more '#' with the frame number, which is always 0 here:
// "shot.####.exr" becomes "shot.0000.exr".
std::string expand_frame_zero(std::string name);

// The paths are absolute and need not exist.
struct FarmFolder {
  // `name` is the path of an output, as the user gave it, or of the folder itself.
  explicit FarmFolder(const std::string& name);

  std::string file(const std::string& name) const { return path + "/" + name; }
  std::string progress(uint32_t part) const;
  std::string plan_progress() const { return file("progress/plan.json"); }
  std::string plan() const { return file("frame.plan"); }
  std::string plan_checkpoint() const { return plan() + ".checkpoint"; }
  std::string checkpoint(uint32_t part, uint32_t parts) const;
  // Whether Slurm opens the logs. It cannot if the folder's path contains %, \ or a control
  // character: Slurm interprets % and \ in the names of logs, and no way of escaping works for
  // both. In that case, the scripts open their logs themselves.
  bool slurm_writes_logs() const {
    return std::ranges::none_of(
        path, [](unsigned char c) { return c == '%' || c == '\\' || c < 0x20 || c == 0x7f; });
  }

  std::string path, output;
};

struct FarmRecord {
  std::string scene;
  uint32_t parts = 0;
  SlurmRequest request;
  bool makes_plan = false;        // plan.sh makes frame.plan, which the parts need
  std::optional<uint64_t> plan;   // the last job of plan.sh
  std::vector<uint64_t> arrays;   // job arrays of the parts, in the order of submission
  std::optional<uint64_t> merge;  // the job of the merge; absent: nothing was submitted

  std::vector<uint64_t> jobs() const;  // the arrays and, if set, plan and merge
};

// Validates the file. Throws InputError if it is missing or invalid.
FarmRecord read_record(const FarmFolder& folder);
std::string record_json(const FarmRecord& record);

}  // namespace emberline
