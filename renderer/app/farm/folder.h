// OUTPUT.farm: what `emberline farm` keeps of a frame that is rendered in parts.
//
//   settings.json   of the frame, for `render --settings`
//   part.sh         renders a part, merge.sh makes the picture of them
//   job.json        what was submitted: FarmRecord
//   progress/       part-K.json, as of render --progress-file
//   logs/           part-K.log, merge.log
//   merge.json      the report of the merge; there when it is done
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/farm/slurm.h"

namespace emberline {

// "shot.####.exr" -> "shot.0000.exr": the number of the frame, which is 0 until there is animation.
// Every run of four or more '#'.
std::string frame_file(std::string name);

// Absolute paths. None of them has to be there.
struct FarmFolder {
  // `name` is an output as it was given, or the folder itself.
  explicit FarmFolder(const std::string& name);

  std::string file(const std::string& name) const { return path + "/" + name; }
  std::string progress(uint32_t part) const;
  std::string checkpoint(uint32_t part, uint32_t parts) const;
  // Slurm reads % and \ in the names of logs, and there is no way to write both. In a folder with
  // such a name, or with control characters, the scripts open their logs themselves.
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
  std::vector<uint64_t> arrays;   // of the parts, the last submitted last
  std::optional<uint64_t> merge;  // absent: nothing was submitted

  std::vector<uint64_t> jobs() const;  // all of them
};

// Throws InputError if there is no record or it is not a valid one: its contents are not trusted.
FarmRecord read_record(const FarmFolder& folder);
std::string record_json(const FarmRecord& record);

}  // namespace emberline
