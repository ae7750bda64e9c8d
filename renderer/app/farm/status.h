// `emberline farm status`: reads the progress of each part from its progress file and from Slurm.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/farm/folder.h"

namespace emberline {

// kStopped: the part can be resumed from its checkpoint. kFailed: the part's log has the reason.
// kUnknown: neither the part nor Slurm reports a state.
enum class PartState : uint8_t { kWaiting, kRunning, kDone, kStopped, kFailed, kUnknown };

struct PartStatus {
  uint32_t part = 0;  // 0: the plan or the merge
  PartState state = PartState::kWaiting;
  double done = 0;  // fraction, 0 to 1
  uint64_t samples = 0;
  std::optional<double> elapsed_s, left_s;
  std::string node;     // as named by Slurm; without Slurm, the host
  std::string message;  // why the part failed or waits: the log's last line, or Slurm's reason
};

struct FarmStatus {
  std::string output;
  std::vector<PartStatus> parts;
  std::optional<PartStatus> plan;  // absent: the parts need no plan
  PartStatus merge;
  double done = 0;
  std::optional<double> left_s;  // for all parts; absent: unknown
};

// Throws InputError if this output has no farm folder. The files of the parts are validated; an
// invalid file causes a warning.
FarmStatus farm_status(const FarmFolder& folder);

std::string status_text(const FarmStatus& status);
std::string status_json(const FarmStatus& status);

}  // namespace emberline
