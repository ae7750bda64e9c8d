// emberline farm status: how far each part is, from its progress file and what Slurm knows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/farm/folder.h"

namespace emberline {

// Of stopped parts a checkpoint goes on; failed ones say why in their log. kUnknown: neither the
// part nor Slurm says.
enum class PartState : uint8_t { kWaiting, kRunning, kDone, kStopped, kFailed, kUnknown };

struct PartStatus {
  uint32_t part = 0;  // 0: the merge
  PartState state = PartState::kWaiting;
  double done = 0;  // of 1
  uint64_t samples = 0;
  std::optional<double> elapsed_s, left_s;
  std::string node;     // of Slurm, or else the host
  std::string message;  // of what failed or waits: the last line of the log, or Slurm's word
};

struct FarmStatus {
  std::string output;
  std::vector<PartStatus> parts;
  PartStatus merge;
  double done = 0;
  std::optional<double> left_s;  // of all parts; absent: nothing tells
};

// Throws InputError where there is no farm of this output. What a part's files hold is not trusted:
// one that cannot be is a warning.
FarmStatus farm_status(const FarmFolder& folder);

std::string status_text(const FarmStatus& status);
std::string status_json(const FarmStatus& status);

}  // namespace emberline
